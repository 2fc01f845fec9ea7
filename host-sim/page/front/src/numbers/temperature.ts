// Temperatures: the bus has kelvins, a person reads degrees Celsius.

import { formatNumber } from './format';

export const zero_degC_K = 273.15;

/** To 0.1 mK, which is more than the bus has: 273.15 K is 0, also where it comes as a float of 32 bits. */
export function celsius(kelvin: number): number {
  return Math.round((kelvin - zero_degC_K) * 1e4) / 1e4;
}

/** 393.15 as 120 °C. */
export function formatCelsius(kelvin: number, digits = 4): string {
  return `${formatNumber(celsius(kelvin), digits)} °C`;
}
