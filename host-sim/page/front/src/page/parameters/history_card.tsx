import { readText } from '../../parameters/values';
import { history, historyVersion, infos, nameOf } from '../../session/tuning';
import { units } from '../../session/units';

const shown = 8;

export function HistoryCard() {
  void historyVersion.value;
  const { entries } = history.value;
  return (
    <section class="card" data-testid="history">
      <h2>History</h2>
      {entries.length === 0 && (
        <p class="soft small-text">What is written from this page is listed here, and can be undone.</p>
      )}
      <ol class="history">
        {entries.slice(0, shown).map((entry) => (
          <li key={entry.at_ms}>
            <span class="soft">
              {new Date(entry.at_ms).toLocaleTimeString('en-GB')}, {entry.how}
            </span>
            {entry.changes.slice(0, 4).map((change) => (
              <span key={change.name} class="change">
                {nameOf(change.name)}
                <br />
                {readText(infos.value.get(change.name), change.before, units.value)} →{' '}
                <strong>{readText(infos.value.get(change.name), change.after, units.value)}</strong>
              </span>
            ))}
            {entry.changes.length > 4 && <span class="soft">and {entry.changes.length - 4} more</span>}
          </li>
        ))}
      </ol>
    </section>
  );
}
