// A number that is typed, with its unit.

import type { Signal } from '@preact/signals';
import { useState } from 'preact/hooks';
import { formatNumber } from '../../numbers/format';
import { fromShown, type Shown, tidy, toShown } from '../../numbers/units';

interface NumberFieldProps {
  title: string;
  unit: string;
  value: number | null; ///< null: empty
  testid: string;
  set(value: number): void;
  least?: Bound;
  empty?: { means: string; set(): void }; ///< where it may be left empty
}

interface Bound {
  value: number;
  itself: boolean; ///< whether the bound is allowed as well
}

/** What is wrong with a text; '' where nothing is. */
function mistake(text: string, least: Bound | undefined, mayBeEmpty: boolean): string {
  const number = Number(text.replace(',', '.'));
  if (text.trim() === '' ? mayBeEmpty : Number.isFinite(number) && reaches(number, least)) {
    return '';
  }
  const bound = least ? `${least.itself ? ', at least' : ' above'} ${formatNumber(least.value, 7)}` : '';
  return `Write a number${bound}${mayBeEmpty ? ', or leave the field empty' : ''}.`;
}

function reaches(number: number, least: Bound | undefined): boolean {
  return least === undefined || number > least.value || (least.itself && number === least.value);
}

export function NumberField({ title, unit, value, testid, set, least, empty }: NumberFieldProps) {
  const [text, setText] = useState(value === null ? '' : String(value));
  const wrong = mistake(text, least, empty !== undefined);
  return (
    <label class="field narrow">
      <span>
        {title} <small>{unit}</small>
      </span>
      <input
        // A form is not sent while a field shows something else than what would be sent.
        ref={(input) => input?.setCustomValidity(wrong)}
        type="text"
        inputMode="decimal"
        value={text}
        placeholder={empty?.means}
        aria-invalid={wrong !== ''}
        data-testid={testid}
        onInput={(event) => {
          const written = event.currentTarget.value;
          setText(written);
          if (mistake(written, least, empty !== undefined) !== '') {
            return;
          }
          if (written.trim() === '') {
            empty?.set();
          } else {
            set(Number(written.replace(',', '.')));
          }
        }}
      />
    </label>
  );
}

interface SignalFieldProps extends Pick<NumberFieldProps, 'title' | 'testid'> {
  number: Signal<number>;
  scale: Shown; ///< in which the number of the signal is shown and typed
  least?: Bound; ///< of the number of the signal
}

/** One whose number is that of a signal. */
export function SignalField({ number, scale, least, ...rest }: SignalFieldProps) {
  return (
    <NumberField
      {...rest}
      key={scale.unit}
      unit={scale.unit}
      value={tidy(toShown(scale, number.value))}
      set={(value) => {
        number.value = fromShown(scale, value);
      }}
      {...(least && { least: { ...least, value: tidy(toShown(scale, least.value)) } })}
    />
  );
}

interface OptionalFieldProps extends Pick<NumberFieldProps, 'title' | 'testid'> {
  number: Signal<number | null>;
  scale: Shown;
  means: string; ///< what it means to leave it empty
}

/** One that may be left empty, else above 0. */
export function OptionalField({ number, scale, means, ...rest }: OptionalFieldProps) {
  return (
    <NumberField
      {...rest}
      key={scale.unit}
      unit={scale.unit}
      value={number.value === null ? null : tidy(toShown(scale, number.value))}
      set={(value) => {
        number.value = fromShown(scale, value);
      }}
      least={above0}
      empty={{
        means,
        set: () => {
          number.value = null;
        },
      }}
    />
  );
}

export const above0: Bound = { value: 0, itself: false };
export const least0: Bound = { value: 0, itself: true };

export const inSeconds: Shown = { unit: 's', factor: 1, offset: 0 };
