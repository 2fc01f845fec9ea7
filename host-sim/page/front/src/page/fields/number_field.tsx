// A number that is typed, with its unit.

import type { Signal } from '@preact/signals';
import { useState } from 'preact/hooks';
import { fromShown, type Shown, tidy, toShown } from '../../numbers/units';

interface NumberFieldProps {
  title: string;
  unit: string;
  value: number;
  testid: string;
  set(value: number): void;
}

export function NumberField({ title, unit, value, testid, set }: NumberFieldProps) {
  const [text, setText] = useState(String(value));
  const read = Number(text.replace(',', '.'));
  const wrong = text.trim() === '' || !Number.isFinite(read);
  return (
    <label class="field narrow">
      <span>
        {title} <small>{unit}</small>
      </span>
      <input
        type="text"
        inputMode="decimal"
        value={text}
        aria-invalid={wrong}
        data-testid={testid}
        onInput={(event) => {
          const written = event.currentTarget.value;
          setText(written);
          const number = Number(written.replace(',', '.'));
          if (written.trim() !== '' && Number.isFinite(number)) {
            set(number);
          }
        }}
      />
    </label>
  );
}

interface SignalFieldProps extends Pick<NumberFieldProps, 'title' | 'testid'> {
  number: Signal<number>;
  scale: Shown; ///< in which the number of the signal is shown and typed
}

/** One whose number is that of a signal. */
export function SignalField({ number, scale, ...rest }: SignalFieldProps) {
  return (
    <NumberField
      {...rest}
      key={scale.unit}
      unit={scale.unit}
      value={tidy(toShown(scale, number.value))}
      set={(value) => {
        number.value = fromShown(scale, value);
      }}
    />
  );
}

export const inSeconds: Shown = { unit: 's', factor: 1, offset: 0 };
