() => {
  // Of each sample of the legend, the largest contrast of something drawn in it with what lies
  // behind it: the rectangle below, or the sample's ground.
  const parse = (text) => (text.match(/[\d.]+/g) ?? []).map(Number);
  const linear = (v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
  const luminance = ([r, g, b]) => 0.2126 * linear(r / 255) + 0.7152 * linear(g / 255) + 0.0722 * linear(b / 255);
  const ratio = (one, other) => {
    const [high, low] = [luminance(one), luminance(other)].sort((a, b) => b - a);
    return (high + 0.05) / (low + 0.05);
  };
  const over = (colour, ground, part) => colour.slice(0, 3).map((v, k) => v * part + ground[k] * (1 - part));
  return Object.fromEntries([...document.querySelectorAll("#legend li")].filter((item) => item.checkVisibility()).map((item) => {
    const rect = item.querySelector("rect");
    const ground = parse(rect ? getComputedStyle(rect).fill : getComputedStyle(item.querySelector("svg")).backgroundColor);
    const seen = [...item.querySelectorAll("path, circle")].flatMap((shape) => {
      const style = getComputedStyle(shape);
      return [[style.stroke, style.strokeOpacity], [style.fill, style.fillOpacity]]
        .filter(([colour]) => colour !== "none")
        .map(([colour, part]) => ratio(over(parse(colour), ground, Number(part) * Number(style.opacity)), ground));
    });
    return [item.textContent.trim(), Math.max(...seen)];
  }));
}
