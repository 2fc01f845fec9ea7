// Temperatures: the bus has kelvins, a person reads degrees Celsius.

import { formatNumber } from './format';

export const zero_degC_K = 273.15;

export function celsius(kelvin: number): number {
  return kelvin - zero_degC_K;
}

/** 393.15 as 120 °C. */
export function formatCelsius(kelvin: number, digits = 4): string {
  return `${formatNumber(celsius(kelvin), digits)} °C`;
}
