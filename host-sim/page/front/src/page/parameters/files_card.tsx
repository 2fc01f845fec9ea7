// Settings as a file: dump, compare, restore; or as lines of `host-sim can set`.

import { useState } from 'preact/hooks';
import { readText } from '../../parameters/values';
import type { Difference } from '../../protocol/bridge';
import { saveText } from '../../session/download';
import { sayError, sayFileError } from '../../session/notices';
import { call, mayWrite, node } from '../../session/session';
import { infos, nameOf, restore } from '../../session/tuning';
import { units } from '../../session/units';

interface Compared {
  name: string;
  toml: string;
  differences: Difference[];
}

export function FilesCard() {
  const [compared, setCompared] = useState<Compared | null>(null);
  const dump = async (as: 'toml' | 'can'): Promise<void> => {
    try {
      const answer = await call('dump', { node: node.value, as });
      saveText(as === 'toml' ? `node${node.value}.toml` : `node${node.value}.sh`, String(answer['text']));
    } catch (error) {
      sayError(error);
    }
  };
  const compare = async (input: HTMLInputElement): Promise<void> => {
    const file = input.files?.[0];
    if (!file) {
      return;
    }
    try {
      const toml = await file.text();
      const answer = await call('diff', { node: node.value, toml });
      setCompared({ name: file.name, toml, differences: (answer['differences'] ?? []) as Difference[] });
    } catch (error) {
      sayFileError(error, file.name);
    }
    input.value = '';
  };
  return (
    <section class="card" data-testid="files">
      <h2>Settings as a file</h2>
      <div class="bar wrap">
        <button type="button" data-testid="dump-toml" onClick={() => void dump('toml')}>
          Save settings file
        </button>
        <button type="button" data-testid="dump-can" title="Lines of host-sim can set" onClick={() => void dump('can')}>
          Save CAN lines
        </button>
        <label class="button file-button">
          Compare with a file …
          <input
            type="file"
            accept=".toml,text/plain"
            data-testid="diff-file"
            onChange={(event) => void compare(event.currentTarget)}
          />
        </label>
      </div>
      {compared && (
        <div data-testid="differences">
          <p>
            <strong>{compared.name}</strong>:{' '}
            {compared.differences.length === 0
              ? 'no differences.'
              : compared.differences.length === 1
                ? '1 difference.'
                : `${compared.differences.length} differences.`}
          </p>
          {compared.differences.length > 0 && (
            <>
              <div class="scroll-x">
                <table>
                  <thead>
                    <tr>
                      <th>Parameter</th>
                      <th>Servo</th>
                      <th>File</th>
                    </tr>
                  </thead>
                  <tbody>
                    {compared.differences.map((one) => (
                      <tr key={one.name}>
                        <td>{nameOf(one.name)}</td>
                        <td>{readText(infos.value.get(one.name), one.node, units.value)}</td>
                        <td>{readText(infos.value.get(one.name), one.file, units.value)}</td>
                      </tr>
                    ))}
                  </tbody>
                </table>
              </div>
              <div class="bar">
                <button
                  type="button"
                  class="primary"
                  data-testid="restore"
                  disabled={!mayWrite.value}
                  onClick={() => {
                    void restore(compared.name, compared.toml);
                    setCompared(null);
                  }}>
                  Write the file's values
                </button>
                <button type="button" onClick={() => setCompared(null)}>
                  Close
                </button>
              </div>
            </>
          )}
        </div>
      )}
    </section>
  );
}
