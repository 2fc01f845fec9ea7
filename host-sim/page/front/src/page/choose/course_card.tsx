// How the selected wire contracts and comes back.

import { useEffect, useRef } from 'preact/hooks';
import { formatNumber } from '../../numbers/format';
import { type Quantity, quantityText, scaleOf } from '../../numbers/units';
import { PlotGroup } from '../../plot/group';
import { type SeriesSpec, TimePlot } from '../../plot/time_plot';
import type { ChosenWire } from '../../protocol/bridge';
import { units } from '../../session/units';
import { samplesOf } from './course';
import { type Found, selected } from './found';

export function CourseCard({ wire, answer }: { wire: ChosenWire; answer: Found }) {
  const text = (quantity: Quantity, value: number): string => quantityText(quantity, value, units.value, 3);
  return (
    <section class="card" aria-labelledby="course-title" data-testid="choose-course">
      <h2 id="course-title">
        {wire.parallel > 1 && `${wire.parallel} × `}
        {wire.wire}, {text('wire_m', wire.length_m)}
      </h2>
      <p class="soft">
        It contracts by {formatNumber(100 * wire.strain, 3)} % of its length under {text('Pa', wire.stress_Pa)}. When it
        is cold, {text('Pa', wire.cold_stress_Pa)} pull it back.
      </p>
      {wire.note && <p data-testid="choose-note">{wire.note}</p>}
      {wire.overheats_s !== null && (
        <p class="caution" data-testid="choose-warning">
          At {text('A', wire.current_A)} this wire passes its limit of temperature after{' '}
          {formatNumber(wire.overheats_s, 3)} s: switch to at most {text('A', wire.hold_current_A)} (what holds it) when
          it has contracted.
        </p>
      )}
      <Plots wire={wire} answer={answer} />
    </section>
  );
}

function Plots({ wire, answer }: { wire: ChosenWire; answer: Found }) {
  const place = useRef<HTMLDivElement>(null);
  const choice = units.value;
  useEffect(() => {
    const samples = samplesOf(wire.course);
    const extent: [number, number] | null = samples.end > 0 ? [samples.x(0), samples.x(samples.end - 1)] : null;
    const group = new PlotGroup({ x: 'seconds', extent: () => extent });
    const { unit: way, ...inWays } = scaleOf('wire_m', choice);
    const { unit: degrees, ...inDegrees } = scaleOf('K', choice);
    const contraction: SeriesSpec[] = [
      { key: 'still', label: 'still air', role: 'estimate', width: 2, ...inWays },
      {
        key: 'fan',
        label: `fan, ${formatNumber(answer.fan_m_s)} m/s`,
        role: 'measured',
        style: 'dashed',
        width: 2,
        ...inWays,
      },
    ];
    const plots = [
      new TimePlot(
        place.current!,
        group,
        { id: 'choose-contraction', title: 'Contraction', unit: way, height: 230, series: contraction },
        samples,
      ),
      new TimePlot(
        place.current!,
        group,
        {
          id: 'choose-temperature',
          title: 'Temperature',
          unit: degrees,
          height: 170,
          series: [{ key: 'temperature', label: 'still air', role: 'temperature', ...inDegrees }],
          xLabel: 'time since the current was switched on in s',
        },
        samples,
      ),
    ];
    return () => plots.forEach((plot) => plot.destroy());
  }, [answer.id, selected.value, choice]);
  return <div class="side" ref={place} />;
}
