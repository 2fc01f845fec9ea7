// The states of CiA 402 as a picture; the one in force is filled.

import type { Drive } from '../../protocol/bridge';
import { driveNames } from './drive';

interface Box {
  state: Drive;
  x: number;
  y: number;
}
const width = 150;
const height = 44;
const boxes: Box[] = [
  { state: 'not_ready', x: 10, y: 16 },
  { state: 'switch_on_disabled', x: 210, y: 16 },
  { state: 'ready', x: 210, y: 100 },
  { state: 'switched_on', x: 210, y: 184 },
  { state: 'operation_enabled', x: 210, y: 268 },
  { state: 'quick_stop', x: 10, y: 268 },
  { state: 'fault', x: 410, y: 16 },
  { state: 'fault_reaction', x: 410, y: 184 },
];

const arrows: [string, string?][] = [
  ['M160 38 H206'],
  ['M270 60 V96'], ['M300 100 V64'],
  ['M270 144 V180'], ['M300 184 V148'],
  ['M270 228 V264'], ['M300 268 V232'],
  ['M210 290 H164'],
  ['M85 268 V92 Q85 80 97 80 H228 Q240 80 240 68 V64'],
  ['M360 284 H470 Q485 284 485 268 V232'],
  ['M485 184 V64'],
  ['M410 38 H364'],
];

export function Machine({ now }: { now: Drive | null }) {
  const powered = now === 'operation_enabled' || now === 'quick_stop' || now === 'fault_reaction';
  return (
    <svg class="machine" viewBox="0 0 570 328" role="img" data-testid="machine" data-state={now ?? ''}
      aria-label={now ? `State machine of the drive: ${driveNames[now]}` : 'State machine of the drive: not known'}>
      <defs>
        <marker id="tip" viewBox="0 0 8 8" refX="6" refY="4" markerWidth="7" markerHeight="7" orient="auto">
          <path d="M0 0 L8 4 L0 8 z" class="tip" />
        </marker>
      </defs>
      {arrows.map(([path]) => <path key={path} d={path} class="arrow" marker-end="url(#tip)" />)}
      <text x="436" y="278" class="arrow-text" text-anchor="middle">fault</text>
      <text x="387" y="30" class="arrow-text" text-anchor="middle">reset</text>
      <text x="262" y="252" class="arrow-text" text-anchor="end">enable</text>
      <text x="308" y="252" class="arrow-text">disable</text>
      {boxes.map((box) => {
        const is = box.state === now;
        const words = driveNames[box.state];
        const hot = ['operation_enabled', 'quick_stop', 'fault_reaction'].includes(box.state);
        const kind = !is ? '' : box.state.startsWith('fault') ? ' is fault' : powered ? ' is on' : ' is';
        return (
          <g key={box.state} class={`box${kind}`} data-state={box.state} aria-current={is ? 'true' : undefined}>
            <rect x={box.x} y={box.y} width={width} height={height} rx="8" />
            <text x={box.x + width / 2} y={box.y + (hot ? 20 : 27)} text-anchor="middle">{words}</text>
            {hot && <text x={box.x + width / 2} y={box.y + 35} text-anchor="middle" class="sub">current may flow</text>}
          </g>
        );
      })}
    </svg>
  );
}
