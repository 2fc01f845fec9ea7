// What the wire has to do: the fields.

import type { Signal } from '@preact/signals';
import { scaleOf, type Shown } from '../../numbers/units';
import { link } from '../../session/session';
import { units } from '../../session/units';
import { above0, inSeconds, least0, OptionalField, SignalField } from '../fields/number_field';
import { asking, find, refused } from './found';
import { counts, lives, pulls, wish } from './wish';

// A fan is said in m/s in both choices of units.
const inMetresPerSecond: Shown = { unit: 'm/s', factor: 1, offset: 0 };

const pullTexts: Record<(typeof pulls)[number], string> = {
  weight: 'the load (a weight)',
  nothing: 'nothing: add a spring',
  spring: 'my spring',
};
const lifeTexts: Record<(typeof lives)[number], string> = {
  long: "long (the makers' suggestion)",
  short: "short (the makers' maximum)",
};

interface ChoiceProps<T extends string | number> {
  title: string;
  testid: string;
  choices: readonly T[];
  chosen: Signal<T>;
  text(choice: T): string;
}

function ChoiceField<T extends string | number>({ title, testid, choices, chosen, text }: ChoiceProps<T>) {
  return (
    <label class="field">
      <span>{title}</span>
      <select
        value={chosen.value}
        data-testid={testid}
        onChange={(event) => {
          chosen.value = choices[event.currentTarget.selectedIndex] ?? choices[0]!;
        }}>
        {choices.map((choice) => (
          <option key={choice} value={choice}>
            {text(choice)}
          </option>
        ))}
      </select>
    </label>
  );
}

export function WishForm() {
  const choice = units.value;
  const length = scaleOf('wire_m', choice);
  const volts = scaleOf('V', choice);
  const newtons = scaleOf('N', choice);
  return (
    <form
      class="card"
      data-testid="choose-form"
      onSubmit={(event) => {
        event.preventDefault();
        if (!asking.value) {
          void find();
        }
      }}>
      <h2>Choose a wire</h2>
      <p class="soft">
        Say what the wire has to do. The page computes which wires of the makers' tables do it, with which current, and
        how fast they come back. No servo is needed, and none is changed.
      </p>
      <div class="bar wrap ends" role="group" aria-label="What the wire has to do">
        <SignalField title="Force" scale={newtons} number={wish.force_N} least={above0} testid="choose-force" />
        <SignalField title="Stroke" scale={length} number={wish.stroke_m} least={above0} testid="choose-stroke" />
        <SignalField
          title="Time to contract"
          scale={inSeconds}
          number={wish.time_s}
          least={above0}
          testid="choose-time"
        />
        <OptionalField
          title="Wire's length"
          scale={length}
          number={wish.length_m}
          means="computed"
          testid="choose-length"
        />
        <OptionalField title="Supply" scale={volts} number={wish.supply_V} means="any" testid="choose-supply" />
      </div>
      <div class="bar wrap ends" role="group" aria-label="How the wire comes back">
        <ChoiceField
          title="Pulled back by"
          choices={pulls}
          chosen={wish.pull}
          text={(one) => pullTexts[one]}
          testid="choose-pull"
        />
        {wish.pull.value === 'spring' && (
          <>
            <SignalField
              title="Its preload"
              scale={newtons}
              number={wish.spring_N}
              least={least0}
              testid="choose-spring-force"
            />
            <SignalField
              title="Its rate"
              scale={scaleOf('N_m', choice)}
              number={wish.spring_N_m}
              least={least0}
              testid="choose-spring-rate"
            />
          </>
        )}
        <SignalField
          title="Air"
          scale={scaleOf('K', choice)}
          number={wish.ambient_K}
          least={above0}
          testid="choose-air"
        />
        <SignalField title="Fan" scale={inMetresPerSecond} number={wish.fan_m_s} least={least0} testid="choose-fan" />
      </div>
      <div class="bar wrap ends">
        <ChoiceField
          title="Life"
          choices={lives}
          chosen={wish.life}
          text={(one) => lifeTexts[one]}
          testid="choose-life"
        />
        <ChoiceField
          title="Wires side by side, up to"
          choices={counts}
          chosen={wish.parallel}
          text={String}
          testid="choose-parallel"
        />
        <button
          type="submit"
          class="big primary"
          disabled={asking.value || link.value !== 'open'}
          data-testid="choose-find">
          {asking.value ? 'Looking …' : 'Find wires'}
        </button>
      </div>
      {refused.value && (
        <p class="refused" data-testid="choose-refused">
          {refused.value}
        </p>
      )}
    </form>
  );
}
