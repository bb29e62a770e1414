// The script of report.html: numbers as text, films, replays, and plots that respond to the pointer. Without it, plots are images.
"use strict";
const { max, min } = Math;
const superscript = (number) => String(number).replace(/./g, (sign) => sign === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[sign]);
const exponentOf = (value) => value ? Math.floor(Math.log10(Math.abs(value) * (1 + 1e-12))) : 0;

// A number in the notation of the tables, with its standard error in the last digits.
function number(value, error, count = 6) {
  const exponent = exponentOf(max(Math.abs(value), error || 0)), isPlain = exponent >= -3 && exponent <= 5 && !(error >= 10);
  const unit = isPlain ? 1 : 10 ** exponent, scaled = value / unit;
  let text = String(Number(scaled.toPrecision(count)));
  if (error > 1e-9 * Math.abs(value)) {
    const decimals = clamp(1 - exponentOf(error / unit), 0, 20);
    text = `${scaled.toFixed(decimals)}(${Math.round(error / unit * 10 ** decimals)})`;
  }
  text = text.replace("-", "−");
  if (isPlain) return text;
  return (text === "1" ? "" : text + "·") + "10" + superscript(exponent);
}

const clamp = (value, low, high) => max(low, min(high, value));
const withUnit = (text, unit) => unit ? `${text} ${unit}` : text;
const on = (target, type, respond) => target.addEventListener(type, respond);
