// A zone's area: a polygon, a circle, or a band along a line. Metres; no drawing, no page.
//
// An area is {shape, points, radius_m, width_m}: a circle has its centre as its only point. A mask's
// area has `outlines` and cannot be changed.

import { surrounds } from "./world.js";

export const SHAPES = { polygon: "Polygon", circle: "Circle", line: "Band" };
export const FEWEST = { polygon: 3, circle: 1, line: 2 };

/** The area of a zone as the program sends it. */
export function areaOf(zone) {
  if (zone.outlines) return { shape: "mask", points: [], outlines: zone.outlines };
  if (zone.circle) return { shape: "circle", points: [zone.circle.slice(0, 2)], radius_m: zone.circle[2] };
  if (zone.line) return { shape: "line", points: zone.line, width_m: zone.width_m };
  return { shape: "polygon", points: zone.polygon };
}

/** A zone's keys for its area. */
export function written({ shape, points, radius_m, width_m }) {
  if (shape === "circle") return { circle: [...points[0], radius_m] };
  return shape === "line" ? { line: points, width_m } : { polygon: points };
}

export function moved(area, dx, dy) {
  return { ...area, points: area.points.map(([x, y]) => [round(x + dx), round(y + dy)]) };
}

export function covers(area, x, y) {
  switch (area.shape) {
    case "circle":
      return area.points.length > 0 && Math.hypot(area.points[0][0] - x, area.points[0][1] - y) <= area.radius_m;
    case "line":
      return area.points.some((b, k) => k > 0 && distance(area.points[k - 1], b, x, y) <= area.width_m / 2);
    default:
      return (area.outlines ?? [area.points]).reduce((odd, ring) => odd !== surrounds(ring, x, y), false);
  }
}

/** Places along a line, `every` metres apart and in the middle of what is left: [[x, y, angle], ...]. */
export function along(points, every) {
  const lengths = points.slice(1).map(([x, y], k) => Math.hypot(x - points[k][0], y - points[k][1]));
  const whole = lengths.reduce((sum, one) => sum + one, 0);
  const count = Math.max(1, Math.floor(whole / every));
  const places = [];
  for (let n = 0; n < count; n++) {
    let at = ((n + 0.5) * whole) / count;
    let k = 0;
    while (k + 1 < lengths.length && at > lengths[k]) at -= lengths[k++];
    if (!lengths[k]) continue;
    const [[ax, ay], [bx, by]] = [points[k], points[k + 1]];
    const part = at / lengths[k];
    places.push([ax + part * (bx - ax), ay + part * (by - ay), Math.atan2(by - ay, bx - ax)]);
  }
  return places;
}

/** Places as text, one a line, and back; null if a line is none. */
export const asText = (points) => points.map(([x, y]) => `${short(x)}, ${short(y)}`).join("\n");
export function fromText(text) {
  const rows = text.split("\n").map((row) => row.trim()).filter(Boolean);
  const points = rows.map((row) => row.split(/[\s,;]+/).map(Number));
  return points.every((point) => point.length === 2 && point.every(Number.isFinite)) ? points : null;
}

export const round = (metres) => Math.round(metres * 1e3) / 1e3;
export const short = (metres) => String(round(metres));

function distance([ax, ay], [bx, by], x, y) {
  const [dx, dy] = [bx - ax, by - ay];
  const long = dx * dx + dy * dy;
  const t = long > 0 ? Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / long)) : 0;
  return Math.hypot(ax + t * dx - x, ay + t * dy - y);
}
