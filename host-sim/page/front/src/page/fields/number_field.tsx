// A number that is typed, with its unit.

import type { Signal } from '@preact/signals';
import { useState } from 'preact/hooks';

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

/** One whose number is that of a signal. */
export function SignalField({
  number,
  ...rest
}: Pick<NumberFieldProps, 'title' | 'unit' | 'testid'> & { number: Signal<number> }) {
  return (
    <NumberField
      {...rest}
      value={number.value}
      set={(value) => {
        number.value = value;
      }}
    />
  );
}
