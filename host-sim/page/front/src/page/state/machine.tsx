// The states of CiA 402 as a picture; the one in force is filled.

import type { Drive } from '../../protocol/bridge';
import { driveNames } from './drive';

interface Box {
  state: Drive;
  x: number;
  y: number;
}
const width = 160;
const height = 44;
const boxes: Box[] = [
  { state: 'not_ready', x: 6, y: 16 },
  { state: 'switch_on_disabled', x: 200, y: 16 },
  { state: 'ready', x: 200, y: 100 },
  { state: 'switched_on', x: 200, y: 184 },
  { state: 'operation_enabled', x: 200, y: 268 },
  { state: 'quick_stop', x: 6, y: 268 },
  { state: 'fault', x: 394, y: 16 },
  { state: 'fault_reaction', x: 394, y: 184 },
];

const arrows = [
  'M166 38 H196',
  'M265 60 V96',
  'M295 100 V64',
  'M265 144 V180',
  'M295 184 V148',
  'M265 228 V264',
  'M295 268 V232',
  'M200 290 H170',
  'M86 268 V92 Q86 80 98 80 H222 Q234 80 234 68 V64',
  'M360 284 H459 Q474 284 474 268 V232',
  'M474 184 V64',
  'M394 38 H364',
];

export function Machine({ now }: { now: Drive | null }) {
  const powered = now === 'operation_enabled' || now === 'quick_stop' || now === 'fault_reaction';
  return (
    <svg
      class="machine"
      viewBox="0 0 560 328"
      role="img"
      data-testid="machine"
      data-state={now ?? ''}
      aria-label={now ? `State machine of the drive: ${driveNames[now]}` : 'State machine of the drive: not known'}>
      <defs>
        <marker id="tip" viewBox="0 0 8 8" refX="6" refY="4" markerWidth="7" markerHeight="7" orient="auto">
          <path d="M0 0 L8 4 L0 8 z" class="tip" />
        </marker>
      </defs>
      {arrows.map((path) => (
        <path key={path} d={path} class="arrow" marker-end="url(#tip)" />
      ))}
      <text x="420" y="278" class="arrow-text" text-anchor="middle">
        fault
      </text>
      <text x="378" y="30" class="arrow-text" text-anchor="middle">
        reset
      </text>
      <text x="257" y="252" class="arrow-text" text-anchor="end">
        enable
      </text>
      <text x="303" y="252" class="arrow-text">
        disable
      </text>
      {boxes.map((box) => {
        const is = box.state === now;
        const words = driveNames[box.state];
        const hot = ['operation_enabled', 'quick_stop', 'fault_reaction'].includes(box.state);
        const kind = !is ? '' : box.state.startsWith('fault') ? ' is fault' : powered ? ' is on' : ' is';
        return (
          <g key={box.state} class={`box${kind}`} data-state={box.state} aria-current={is ? 'true' : undefined}>
            <rect x={box.x} y={box.y} width={width} height={height} rx="8" />
            <text x={box.x + width / 2} y={box.y + (hot ? 20 : 27)} text-anchor="middle">
              {words}
            </text>
            {hot && (
              <text x={box.x + width / 2} y={box.y + 35} text-anchor="middle" class="sub">
                current may flow
              </text>
            )}
          </g>
        );
      })}
    </svg>
  );
}
