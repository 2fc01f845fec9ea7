import { expect, test } from 'vitest';
import { Box, include } from '../../src/plot/box';
import type { Scales, Span } from '../../src/plot/chart';

const all = (): Scales => ({ x: [0, 10], y: [-2, 2] });

test('gestures change both axes of what is shown', () => {
  let changes = 0;
  const box = new Box(() => ++changes);
  expect(box.measure(all)).toEqual(all());
  box.pan(0.1, -0.25);
  expect(box.measure(all)).toEqual({ x: [1, 11], y: [-3, 1] });
  box.zoomAt(0.5, 1, -3);
  expect(box.measure(all)).toEqual({ x: [1, 6], y: [-3, -1] });
  box.zoom([2, 3], [0, 1]);
  expect(box.measure(all)).toEqual({ x: [2, 3], y: [0, 1] });
  box.reset();
  expect(box.measure(all)).toEqual(all());
  expect(changes).toBe(4);
});

test('a rectangle without an area is not zoomed to', () => {
  const box = new Box(() => {}, false, { x: [0, 1], y: [0, 1] });
  box.zoom([2, 3], [1, 1]);
  expect(box.measure(all)).toEqual({ x: [0, 1], y: [0, 1] });
});

test('the shorter axis is widened around its middle until a unit is as long in both', () => {
  const box = new Box(() => {});
  expect(box.measure(all, { width: 100, height: 100 })).toEqual({ x: [0, 10], y: [-5, 5] });
  box.zoomAt(0.5, 0, 0);
  expect(box.measure(all, { width: 100, height: 100 })).toEqual({ x: [0, 5], y: [-2.5, 2.5] });
});

test('a span comes to hold values and ranges, but not what is missing', () => {
  const span: Span = [Infinity, -Infinity];
  include(span, 3);
  include(span, NaN, NaN);
  include(span, -1, 2);
  expect(span).toEqual([-1, 3]);
});
