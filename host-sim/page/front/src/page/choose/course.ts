// The courses in still air and with the fan, which have times of their own, as rows of one plot.

import { ArraySamples } from '../../numbers/columns';
import type { Course } from '../../protocol/bridge';

export function samplesOf(course: Course): ArraySamples {
  const times = [...new Set([...course.time_s, ...course.fan_time_s])].sort((a, b) => a - b);
  return new ArraySamples(times, {
    still: between(times, course.time_s, course.contraction_m),
    fan: between(times, course.fan_time_s, course.fan_contraction_m),
    temperature: between(times, course.time_s, course.temperature_K),
  });
}

/** Linear between the rows of xs and ys; nothing before the first and after the last. Both x ascend. */
function between(times: readonly number[], xs: readonly number[], ys: readonly number[]): (number | null)[] {
  let next = 0;
  return times.map((time) => {
    while (next < xs.length && xs[next]! < time) {
      ++next;
    }
    if (xs[next] === time) {
      return ys[next]!;
    }
    if (next === 0 || next === xs.length) {
      return null;
    }
    const share = (time - xs[next - 1]!) / (xs[next]! - xs[next - 1]!);
    return ys[next - 1]! + share * (ys[next]! - ys[next - 1]!);
  });
}
