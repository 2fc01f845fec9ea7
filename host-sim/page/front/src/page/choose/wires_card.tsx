// The wires that do it, one of which is selected, and why the others do not.

import { formatNumber } from '../../numbers/format';
import { type Quantity, scaleOf, type Shown, toShown, type Units } from '../../numbers/units';
import type { Choice, ChosenWire } from '../../protocol/bridge';
import { units } from '../../session/units';
import { inSeconds } from '../fields/number_field';
import { type Found, outdated, selected } from './found';

interface Column {
  title: string;
  unit: string;
  text(wire: ChosenWire): string;
}

function columnsOf(choice: Units): Column[] {
  const number = (
    title: string,
    quantity: Quantity | Shown,
    of: (wire: ChosenWire) => number | null,
    absent = '–',
  ): Column => {
    const scale = typeof quantity === 'string' ? scaleOf(quantity, choice) : quantity;
    const text = (wire: ChosenWire): string => {
      const value = of(wire);
      return value === null ? absent : formatNumber(toShown(scale, value), 3);
    };
    return { title, unit: scale.unit, text };
  };
  const preload = scaleOf('N', choice);
  const rate = scaleOf('N_m', choice);
  return [
    { title: 'Side by side', unit: '', text: ({ parallel }) => String(parallel) },
    number('Length', 'wire_m', ({ length_m }) => length_m),
    number('Current', 'A', ({ current_A }) => current_A),
    number('Voltage', 'V', ({ voltage_V }) => voltage_V),
    number('Power', inWatts, ({ power_W }) => power_W),
    number('Holds at', 'A', ({ hold_current_A }) => hold_current_A),
    number('Hottest', 'K', ({ hottest_K }) => hottest_K),
    number('Back in still air', inSeconds, ({ back_still_s }) => back_still_s, 'never'),
    number('Back with the fan', inSeconds, ({ back_fan_s }) => back_fan_s, 'never'),
    number('Stress', 'Pa', ({ stress_Pa }) => stress_Pa),
    { title: 'Cycles', unit: '', text: ({ cycles }) => cycles },
    {
      title: 'Bias spring',
      unit: `${preload.unit} + ${rate.unit}`,
      text: ({ spring_N, spring_N_m }) =>
        spring_N === null || spring_N_m === null
          ? '–'
          : `${formatNumber(toShown(preload, spring_N), 3)} + ${formatNumber(toShown(rate, spring_N_m), 3)}`,
    },
  ];
}

// That of a whole wire, which takes watts; in the mW of the bench it would have four digits.
const inWatts: Shown = { unit: 'W', factor: 1, offset: 0 };

export function WiresCard({ answer }: { answer: Found }) {
  const { wires, others } = answer;
  const columns = columnsOf(units.value);
  return (
    <section class="card" aria-labelledby="wires-title">
      <div class="card-head">
        <h2 id="wires-title">Wires that do it</h2>
        <span class="soft" role="status" data-testid="choose-count">
          {wires.length === 0 ? 'none' : wires.length} of {wires.length + others.length} wires
        </span>
      </div>
      {outdated.value && (
        <p class="soft" data-testid="choose-outdated">
          The fields have been changed since. What is shown is the answer to what they said before.
        </p>
      )}
      {wires.length === 0 ? (
        <p>No wire of the makers' tables does this. Below is what each of them lacks.</p>
      ) : (
        <div class="scroll-x">
          <table class="figures wires" data-testid="choose-wires">
            <caption class="hidden">Wires that do it. The course of the selected one is drawn below.</caption>
            <thead>
              <tr>
                <th scope="col">Wire</th>
                {columns.map(({ title, unit }) => (
                  <th key={title} scope="col">
                    {title}
                    <small>{unit}</small>
                  </th>
                ))}
              </tr>
            </thead>
            <tbody>
              {wires.map((wire, row) => (
                <WireRow key={`${answer.id}-${row}`} wire={wire} row={row} columns={columns} />
              ))}
            </tbody>
          </table>
        </div>
      )}
    </section>
  );
}

function WireRow({ wire, row, columns }: { wire: ChosenWire; row: number; columns: Column[] }) {
  const chosen = row === selected.value;
  const select = (): void => {
    selected.value = row;
  };
  return (
    <tr class={chosen ? 'chosen' : ''} data-testid="choose-wire" onClick={select}>
      <th scope="row">
        <label>
          <input type="radio" name="choose-wire" checked={chosen} onChange={select} />
          {wire.wire}
        </label>
      </th>
      {columns.map(({ title, text }) => (
        <td key={title}>{text(wire)}</td>
      ))}
    </tr>
  );
}

export function OthersCard({ others }: Pick<Choice, 'others'>) {
  return (
    <section class="card" aria-labelledby="others-title">
      <h2 id="others-title">Why not the others</h2>
      <div class="scroll-x">
        <table class="full reasons" data-testid="choose-others">
          <caption class="hidden">Wires that do not do it, and why</caption>
          <thead>
            <tr>
              <th scope="col">Wire</th>
              <th scope="col">Why not</th>
            </tr>
          </thead>
          <tbody>
            {others.map(({ wire, why }) => (
              <tr key={`${wire} ${why}`}>
                <th scope="row">{wire}</th>
                <td>{why}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </section>
  );
}
