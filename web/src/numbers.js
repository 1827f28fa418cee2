// Numbers as the tables of the page print them (plots/pretty_text.cpp).

const superscripts = "⁰¹²³⁴⁵⁶⁷⁸⁹";

function superscript(whole) {
  return String(whole).replace(/./g, (c) => (c === "-" ? "⁻" : superscripts[c]));
}

const withMinus = (text) => text.replace("-", "−");

/** 0.4, 3.6×10⁻³, ∞; "–" for no number. */
export function prettyNumber(value, digits = 5) {
  if (value == null || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  if (value === 0) return "0";
  const [mantissa, power] = value.toExponential(digits - 1).split("e");
  const exponent = Number(power);
  const shortened = (text) => (text.includes(".") ? text.replace(/\.?0+$/, "") : text);
  if (exponent < -2 || exponent > 5)
    return withMinus(shortened(mantissa)) + "×10" + superscript(exponent);
  return withMinus(shortened(value.toFixed(Math.max(0, digits - 1 - exponent))));
}

export function prettyQuantity(value, unit) {
  return unit ? `${prettyNumber(value)} ${unit}` : prettyNumber(value);
}

/** A tick of a linear axis, with the decimals that the step between ticks has. */
export function linearTick(value, step) {
  let decimals = 0;
  const whole = (number) => Math.abs(number - Math.round(number)) < 1e-6;
  while (decimals < 12 && !whole(step * 10 ** decimals)) ++decimals;
  const text = value.toFixed(decimals);
  return withMinus(/^-0(\.0*)?$/.test(text) ? text.slice(1) : text);
}

const isDecade = (value) => Math.abs(Math.log10(value) - Math.round(Math.log10(value))) < 1e-9;

/** Ticks of a logarithmic axis: 10ⁿ, or where there are others between decades, plain numbers. */
export function logarithmicTicks(values) {
  const decades = values.every((value) => value == null || isDecade(value));
  return values.map((value) => {
    if (value == null) return null;
    return decades ? "10" + superscript(Math.round(Math.log10(value))) : prettyNumber(value, 4);
  });
}
