// One chart at full size: axes, and the value at a moment under the pointer or by the arrow keys.

import { element } from "./stage.js";

const LEFT = 62;
const BOTTOM = 34;
const TOP = 14;
const RIGHT = 16;
const HIGH = 300;
const TICKS = 5;
const SHOWN_LEAST_S = 30;

export class Chart {
  #series = null;
  #at = -1;
  #isFollowing = true;
  #from = null;

  constructor() {
    this.box = document.getElementById("chart");
    this.title = document.getElementById("chart-title");
    this.value = document.getElementById("chart-value");
    this.area = document.getElementById("chart-area");
    this.svg = document.getElementById("chart-svg");
    document.getElementById("chart-close").addEventListener("click", () => this.close());
    this.area.addEventListener("pointermove", (event) => this.#point(event));
    this.area.addEventListener("pointerdown", (event) => this.#point(event));
    this.area.addEventListener("pointerleave", () => this.#choose(-1));
    this.area.addEventListener("keydown", (event) => this.#key(event));
    new ResizeObserver(() => this.#draw()).observe(this.area);
  }

  get isOpen() {
    return !this.box.hidden;
  }

  /** Show a series: {id, title, unit, least, times, values}; `from` gets the focus back. */
  open(series, from) {
    this.#from = from;
    this.#at = -1;
    this.#isFollowing = true;
    this.box.hidden = false;
    this.show(series);
    this.area.focus({ preventScroll: true });
    this.box.scrollIntoView({ block: "nearest" });
  }

  close() {
    if (!this.isOpen) return;
    this.box.hidden = true;
    this.#from?.focus();
  }

  /** The same series with newer values. */
  renew(series) {
    if (!this.isOpen || series.id !== this.#series?.id) return;
    const shift = this.#at >= 0 ? series.times.indexOf(this.#series.times[this.#at]) : -1;
    this.#at = this.#isFollowing ? -1 : shift;
    this.show(series);
  }

  show(series) {
    this.#series = series;
    this.title.textContent = series.title;
    this.area.setAttribute("aria-label", `${series.title}, the last two minutes; arrow keys read a moment`);
    this.#draw();
  }

  #choose(index) {
    if (!this.#series) return;
    this.#isFollowing = index < 0;
    this.#at = index;
    this.#draw();
  }

  #point(event) {
    const { times } = this.#series;
    if (!times.length) return;
    const box = this.svg.getBoundingClientRect();
    const time = this.#timeAt(event.clientX - box.left);
    let best = 0;
    times.forEach((other, k) => { if (Math.abs(other - time) < Math.abs(times[best] - time)) best = k; });
    this.#choose(best);
  }

  #key(event) {
    const last = (this.#series?.times.length ?? 0) - 1;
    const now = this.#at < 0 ? last : this.#at;
    const moves = { ArrowLeft: now - 1, ArrowRight: now + 1, PageUp: now - 20, PageDown: now + 20, Home: 0, End: last };
    if (event.key === "Escape") this.close();
    else if (event.key in moves && last >= 0) this.#choose(Math.min(last, Math.max(0, moves[event.key])));
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  get #wide() {
    return Math.max(240, this.area.clientWidth);
  }

  get #span() {
    const { times } = this.#series;
    const last = times.at(-1) ?? 0;
    return [Math.min(times[0] ?? 0, last - SHOWN_LEAST_S), last];
  }

  #timeAt(pixel) {
    const [begin, end] = this.#span;
    return begin + ((pixel - LEFT) / (this.#wide - LEFT - RIGHT)) * (end - begin);
  }

  #draw() {
    if (!this.isOpen || !this.#series) return;
    const { times, values, unit, least } = this.#series;
    const known = values.filter((value) => value !== null);
    const step = niceStep(Math.max(least, ...known) / TICKS);
    const high = step * Math.ceil(Math.max(least, ...known) / step - 1e-9);
    const [begin, end] = this.#span;
    const wide = this.#wide;
    const x = (time) => LEFT + ((time - begin) / (end - begin)) * (wide - LEFT - RIGHT);
    const y = (value) => TOP + (1 - value / high) * (HIGH - TOP - BOTTOM);
    const parts = [];
    for (let value = 0; value <= high + step / 2; value += step) {
      parts.push(
        element("path", { class: "grid", d: `M${LEFT} ${y(value)}H${wide - RIGHT}` }),
        element("text", { x: LEFT - 8, y: y(value) + 4, "text-anchor": "end" }, Number(value.toPrecision(6)).toString()),
      );
    }
    const seconds = niceStep((end - begin) / Math.max(2, Math.floor(wide / 130)));
    for (let ago = 0; ago <= end - begin + 1e-6; ago += seconds) {
      parts.push(element("text", { x: x(end - ago), y: HIGH - 10, "text-anchor": ago ? "middle" : "end" }, ago ? `−${Number(ago.toPrecision(4))} s` : "now"));
    }
    parts.push(element("text", { x: 4, y: HIGH - 10 }, unit));
    let data = "";
    values.forEach((value, k) => {
      if (value === null) return;
      const begins = k === 0 || values[k - 1] === null;
      const alone = begins && (values[k + 1] ?? null) === null;
      data += `${begins ? "M" : "L"}${x(times[k]).toFixed(1)} ${y(value).toFixed(1)}${alone ? "h0.1" : ""}`;
    });
    parts.push(element("path", { class: "line", d: data }));
    const at = this.#at < 0 ? times.length - 1 : this.#at;
    if (times.length && at >= 0) {
      parts.push(element("path", { class: "cursor", d: `M${x(times[at])} ${TOP}V${HIGH - BOTTOM}` }));
      if (values[at] !== null) parts.push(element("circle", { class: "dot", cx: x(times[at]), cy: y(values[at]), r: 4 }));
    }
    this.svg.setAttribute("viewBox", `0 0 ${wide} ${HIGH}`);
    this.svg.replaceChildren(...parts);
    this.#say(at, times, values, unit);
  }

  #say(at, times, values, unit) {
    const value = values[at] ?? null;
    const ago = times.length ? times.at(-1) - times[at] : 0;
    const when = ago < 0.25 ? "now" : `${ago.toFixed(1)} s ago`;
    this.value.textContent = `${value === null ? "nothing known" : `${value} ${unit}`}, ${when}`;
    this.area.setAttribute("aria-valuemax", Math.max(0, times.length - 1));
    this.area.setAttribute("aria-valuenow", Math.max(0, at));
    this.area.setAttribute("aria-valuetext", this.value.textContent);
  }
}

/** The round number, 1, 2 or 5 times a power of ten, that is not below. */
function niceStep(value) {
  const power = 10 ** Math.floor(Math.log10(Math.max(value, 1e-9)));
  return [1, 2, 5, 10].map((m) => m * power).find((step) => step >= value * 0.999);
}
