import type { Recording } from '../../protocol/bridge';
import { saveBase64 } from '../../session/download';
import { sayError } from '../../session/notices';
import { call } from '../../session/session';

interface SaveButtonsProps {
  recording: Recording;
  disabled?: boolean;
}

/** A recording as a file; the bridge writes it, so that it is the same as that of `host-sim can`. */
export function SaveButtons({ recording, disabled = false }: SaveButtonsProps) {
  const save = async (as: 'csv' | 'mcap'): Promise<void> => {
    try {
      const answer = await call('export', { recording: recording.id ?? recording, as });
      saveBase64(String(answer['name']), String(answer['base64']));
    } catch (error) {
      sayError(error);
    }
  };
  const title = disabled ? 'Of an earlier visit only a picture is left, not all samples' : undefined;
  return (
    <>
      <button
        type="button"
        class="small"
        disabled={disabled}
        title={title}
        data-testid="save-csv"
        onClick={() => void save('csv')}>
        CSV
      </button>
      <button
        type="button"
        class="small"
        disabled={disabled}
        title={title}
        data-testid="save-mcap"
        onClick={() => void save('mcap')}>
        MCAP
      </button>
    </>
  );
}
