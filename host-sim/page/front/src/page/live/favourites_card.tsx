import { go } from '../../session/route';
import { favourites, infos } from '../../session/tuning';
import { EditBar } from '../parameters/edit_bar';
import { ParameterRow } from '../parameters/parameter_row';

export function FavouritesCard({ explained = false }: { explained?: boolean }) {
  const known = favourites.value.flatMap((name) => infos.value.get(name) ?? []);
  return (
    <section class="card" aria-label="Favourite parameters" data-testid="favourites">
      <div class="card-head">
        <h2>Tuning</h2>
        <button type="button" class="link" onClick={() => go('parameters')}>
          All parameters
        </button>
      </div>
      {known.length === 0 && <p class="soft">A parameter with a star is shown here.</p>}
      {known.map((info) => (
        <ParameterRow key={info.name} info={info} compact explained={explained} />
      ))}
      <EditBar />
    </section>
  );
}
