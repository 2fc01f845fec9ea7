// Numbers as a person writes them: 7.6e-05, 0.4, 1013.

const gap = '–';

/** Up to `digits` significant digits without trailing zeros; an exponent below 1e-4 and from 1e7 on. */
export function formatNumber(value: number | null | undefined, digits = 4): string {
  if (value === null || value === undefined || Number.isNaN(value)) {
    return gap;
  }
  if (!Number.isFinite(value)) {
    return value > 0 ? '∞' : '−∞';
  }
  if (value === 0) {
    return '0';
  }
  const size = Math.abs(value);
  if (size >= 1e-4 && size < 1e7) {
    // Digits before the point are never rounded away: 1013.25 is 1013, not 1010.
    const before = Math.floor(Math.log10(size)) + 1;
    const decimals = Math.max(0, Math.min(20, digits - before));
    return minus(trimmed(value.toFixed(decimals)));
  }
  return minus(exponent(value.toExponential(Math.max(0, digits - 1))));
}

/**
 * The shortest text that gives the same number again, where the number was a float of 32 bits (as all
 * REAL32 of the bus are) also the same float: 0.1, not 0.10000000149011612. For fields that are edited, so
 * with an ASCII minus.
 */
export function formatExact(value: number): string {
  if (!Number.isFinite(value)) {
    return String(value);
  }
  if (Number.isInteger(value) && Math.abs(value) < 1e7) {
    return String(value);
  }
  const single = Math.fround(value) === value && !Number.isInteger(value);
  let text = String(value);
  if (single) {
    for (let digits = 1; digits <= 9; ++digits) {
      text = value.toPrecision(digits);
      if (Math.fround(Number(text)) === value) {
        break;
      }
    }
  }
  const number = Number(text);
  const size = Math.abs(number);
  if (size >= 1e-4 && (size < 1e7 || Number.isInteger(value))) {
    return plain(number);
  }
  return exponent(number.toExponential());
}

/** The labels of an axis, with no more digits than steps of `step` need; in plain numbers all with as many decimals. */
export function formatTicks(ticks: readonly number[], step: number): string[] {
  const largest = ticks.reduce((most, tick) => Math.max(most, Math.abs(tick)), 0);
  if (largest >= 1e6 || (largest > 0 && largest < 1e-3)) {
    return ticks.map((tick) => {
      const steps = Math.abs(tick) / step;
      // One more than the steps are in a number of one digit: steps of 2.5 have two.
      return steps < 1e-6 ? '0' : formatNumber(tick, Math.min(15, Math.floor(Math.log10(steps) + 1e-9) + 2));
    });
  }
  const decimals = Math.max(0, Math.min(12, -Math.floor(Math.log10(step) + 1e-9)));
  const needed = isWhole(step * 10 ** decimals) ? decimals : decimals + 1;
  return ticks.map((tick) => {
    const text = tick.toFixed(needed);
    return minus(Number(text) === 0 ? text.replace('-', '') : text);
  });
}

/** Time of day of a Unix time in seconds: 14:03:07, with as many decimals as `step` needs. */
export function formatClock(time_s: number, step = 1): string {
  const shown = time_s + 1e-6; // a tick of 5.25 s may be 5.2499999
  const date = new Date(Math.floor(shown) * 1000);
  const two = (part: number): string => String(part).padStart(2, '0');
  const decimals = step >= 1 ? 0 : Math.min(4, Math.ceil(-Math.log10(step) - 1e-9));
  const fraction = Math.floor((shown - Math.floor(shown)) * 10 ** decimals);
  const text = `${two(date.getHours())}:${two(date.getMinutes())}:${two(date.getSeconds())}`;
  return decimals === 0 ? text : `${text}.${String(fraction).padStart(decimals, '0')}`;
}

/** A duration in words: 12 s, 3 min 5 s, 1 h 2 min. */
export function formatDuration(seconds: number): string {
  const whole = Math.max(0, Math.round(seconds));
  if (whole < 60) {
    return `${whole} s`;
  }
  if (whole < 3600) {
    return `${Math.floor(whole / 60)} min${whole % 60 === 0 ? '' : ` ${whole % 60} s`}`;
  }
  const minutes = Math.round((whole % 3600) / 60);
  return `${Math.floor(whole / 3600)} h${minutes === 0 ? '' : ` ${minutes} min`}`;
}

function isWhole(value: number): boolean {
  return Math.abs(value - Math.round(value)) < 1e-6 * Math.max(1, value);
}

function trimmed(text: string): string {
  return text.includes('.') ? text.replace(/\.?0+$/, '') : text;
}

/** 7.6000e-5 as 7.6e-05, 1.50e+8 as 1.5e+08: as C and every settings file have it. */
function exponent(text: string): string {
  const [mantissa = '', power = '0'] = text.split('e');
  const sign = power.startsWith('-') ? '-' : '+';
  return `${trimmed(mantissa)}e${sign}${power.replace(/^[+-]/, '').padStart(2, '0')}`;
}

/** Without an exponent, which String() begins to write at 1e-7 and 1e21 only. */
function plain(value: number): string {
  return String(value);
}

/** A number that is read, not edited, has a real minus sign in front; the one of an exponent stays. */
function minus(text: string): string {
  return text.startsWith('-') ? `−${text.slice(1)}` : text;
}
