import { tuningText } from '../../parameters/gains';
import { go } from '../../session/route';
import { own } from '../../session/session';
import { drafted, favourites, infos } from '../../session/tuning';
import { EditBar } from '../parameters/edit_bar';
import { ParameterRow } from '../parameters/parameter_row';

export function FavouritesCard({ explained = false }: { explained?: boolean }) {
  const known = favourites.value.flatMap((name) => infos.value.get(name) ?? []);
  const about = tuningText({ ...own.value, ...drafted.value.values });
  return (
    <section class="card" aria-label="Favourite parameters" data-testid="favourites">
      <div class="card-head">
        <h2>Tuning</h2>
        <button type="button" class="link" onClick={() => go('parameters')}>
          All parameters
        </button>
      </div>
      {about && (
        <p class="soft small-text" data-testid="about-gains">
          {about}
        </p>
      )}
      {known.length === 0 && <p class="soft">A parameter with a star is shown here.</p>}
      {known.map((info) => (
        <ParameterRow key={info.name} info={info} compact explained={explained} />
      ))}
      <EditBar />
    </section>
  );
}
