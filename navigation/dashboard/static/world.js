// The arena's borders and diagram as the page keeps them, and the clearance of any place.
//
// Metres, x right, y up. Clearance is the distance to the nearest border or wall, negative inside an
// obstacle; arcs are polylines here, so it is good to about a tenth of a millimetre.

/** The narrowest and widest clearance on the robot's roadmap, for the colours. */
export function clearanceSpan(world) {
  const { chain_first: first, chain_usable: usable, chain_clearance: rho } = world.arrays;
  let low = Infinity;
  let high = -Infinity;
  for (let c = 0; c < usable.length; c++) {
    if (!usable[c]) continue;
    for (let k = first[c]; k < first[c + 1]; k++) {
      low = Math.min(low, rho[k]);
      high = Math.max(high, rho[k]);
    }
  }
  return low <= high ? [low, high] : null;
}

export class Clearance {
  #segments = [];
  #rings = [];

  constructor(arena, world) {
    this.arena = arena;
    if (!world) return;
    const { border, border_first: first, border_closed: closed, border_object: owner } = world.arrays;
    for (let b = 0; b < closed.length; b++) {
      const ring = [];
      for (let k = first[b]; k < first[b + 1]; k++) ring.push([border[2 * k], border[2 * k + 1]]);
      if (closed[b]) this.#rings.push({ owner: owner[b], ring });
      const last = ring.length - 1;
      if (closed[b] && last > 0) this.#segments.push([...ring[last], ...ring[0]]);
      if (last === 0) this.#segments.push([...ring[0], ...ring[0]]);
      for (let k = 0; k < last; k++) this.#segments.push([...ring[k], ...ring[k + 1]]);
    }
  }

  /** {clearance, nearest: [x, y], outside} of a place. */
  at(x, y) {
    const [x0, y0, x1, y1] = this.arena;
    const outside = x < x0 || x > x1 || y < y0 || y > y1;
    let best = Infinity;
    let nearest = [x, y];
    const offer = (px, py) => {
      const d = (px - x) ** 2 + (py - y) ** 2;
      if (d < best) [best, nearest] = [d, [px, py]];
    };
    const cx = Math.min(Math.max(x, x0), x1);
    const cy = Math.min(Math.max(y, y0), y1);
    if (outside) offer(cx, cy);
    else [[x0, y], [x1, y], [x, y0], [x, y1]].forEach(([px, py]) => offer(px, py));
    for (const [ax, ay, bx, by] of this.#segments) {
      const dx = bx - ax;
      const dy = by - ay;
      const long = dx * dx + dy * dy;
      const t = long > 0 ? Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / long)) : 0;
      offer(ax + t * dx, ay + t * dy);
    }
    const distance = Math.sqrt(best);
    const inside = outside || this.#isCovered(x, y);
    return { clearance: inside ? -distance : distance, nearest, outside };
  }

  /** True if an odd number of some object's borders lie around the place. */
  #isCovered(x, y) {
    const odd = new Map();
    for (const { owner, ring } of this.#rings) {
      if (surrounds(ring, x, y)) odd.set(owner, !odd.get(owner));
    }
    return [...odd.values()].some(Boolean);
  }
}

/** True if a closed outline, [[x, y], ...], lies around a place. */
export function surrounds(ring, x, y) {
  let inside = false;
  for (let i = 0, j = ring.length - 1; i < ring.length; j = i++) {
    const [ax, ay] = ring[i];
    const [bx, by] = ring[j];
    if (ay > y !== by > y && x < ((bx - ax) * (y - ay)) / (by - ay) + ax) inside = !inside;
  }
  return inside;
}

/** Places of the numbers that messages name obstacles by: inside each. */
export function obstaclePlaces(world, most) {
  const { border, border_first: first, border_closed: closed, border_object: owner } = world.arrays;
  const places = new Map();
  for (let b = 0; b < closed.length; b++) {
    if (places.has(owner[b])) continue; // its holes come later
    const points = [];
    for (let k = first[b]; k < first[b + 1]; k++) points.push([border[2 * k], border[2 * k + 1]]);
    if (points.length) places.set(owner[b], { owner: owner[b], ...middleOf(points) });
  }
  return places.size <= most ? [...places.values()] : [];
}

/** The middle of a closed outline, inside it: where it is widest half-way up. */
export function middleOf(points) {
  const heights = points.map(([, y]) => y);
  const y = 0.5 * (Math.min(...heights) + Math.max(...heights));
  const crossings = [];
  points.forEach(([ax, ay], k) => {
    const [bx, by] = points[(k + 1) % points.length];
    if (ay > y !== by > y) crossings.push(ax + ((bx - ax) * (y - ay)) / (by - ay));
  });
  crossings.sort((a, b) => a - b);
  let widest = [points[0][0], points[0][0]];
  for (let k = 0; k + 1 < crossings.length; k += 2) {
    if (crossings[k + 1] - crossings[k] > widest[1] - widest[0]) widest = [crossings[k], crossings[k + 1]];
  }
  return { x: 0.5 * (widest[0] + widest[1]), y };
}
