// Link, camera and planner: each a row with a word, a figure and the last two minutes as a line.

import { Chart } from "./chart.js";
import { fill } from "./list.js";

const SVG = "http://www.w3.org/2000/svg";
const [WIDE, HIGH] = [150, 34];
const KEPT = 240;
const SHOWN_LEAST = 60; // half a minute, until there is more

const ROWS = [
  { id: "camera", title: "Camera", column: "camera_hz", least: 30, unit: "pictures/s", judge: cameraWord, detail: cameraDetail },
  { id: "wire", title: "Picture to command", column: "wire_ms", least: 20, unit: "ms", judge: (s) => (s.loop_ms > 1000 ? ["bad", "control loop hangs"] : ["good", "control loop runs"]), detail: (s, last) => both(last("wire_ms"), "ms at most", last("look_ms"), "ms vision") },
  { id: "link", title: "Link to the robot", column: "round_trip_ms", least: 20, unit: "ms", judge: linkWord, detail: linkDetail },
  { id: "planner", title: "Planner", column: "plan_ms", least: 50, unit: "ms", judge: plannerWord, detail: (s) => both(s.times.roadmap_ms, "ms roadmap", s.times.plan_ms, "ms plan") },
  { id: "clearance", title: "Clearance", column: "clearance_m", least: 0.5, unit: "m", judge: () => null, detail: (s) => figure(s.clearance_m, "m") },
  { id: "speed", title: "Speed", column: "speed_m_s", least: 0.2, unit: "m/s", judge: () => null, detail: (s) => figure(s.pose?.speed_m_s ?? null, "m/s") },
];

/** Unusual events of the link: shown from the first time on. */
const ODDITIES = [
  ["taken_back", "taken back from another program", "Another program had the robot and fell silent; this one has taken it back. Look for a second program on the same line."],
  ["stray_hellos", "greetings that were not ours", "The robot has answered a greeting that this program did not send: another program, or an old recording, is on its line. It changes nothing."],
  ["clock_jumps", "jumps of a clock", "The robot's clock or this computer's has jumped, as after a reset or a suspend; it was measured again."],
  ["stale", "permits and poses too old to be sent", "They had waited too long for the line and were left out: the robot gets no old ones. Where it keeps growing, the line or this computer is too slow."],
];

export class Health {
  #columns = [];
  #rows = [];
  #parts = new Map();

  constructor(connection) {
    this.chart = new Chart();
    const box = document.getElementById("health");
    for (const row of ROWS) box.append(this.#make(row));
    connection.on("hello", (hello) => { this.#columns = hello.samples; this.#rows = []; });
    connection.on("samples", (piece) => this.#add(piece));
    connection.on("samples of another", (rows) => { this.#rows = []; this.#add({ items: rows }); });
    connection.on("state", (state) => this.#show(state));
  }

  #make(row) {
    const item = document.createElement("div");
    item.className = "health-row";
    item.id = `health-${row.id}`;
    const title = Object.assign(document.createElement("h3"), { textContent: row.title });
    const word = Object.assign(document.createElement("p"), { className: "word" });
    const detail = Object.assign(document.createElement("p"), { className: "detail", textContent: "–" });
    const chart = document.createElementNS(SVG, "svg");
    chart.setAttribute("viewBox", `0 0 ${WIDE} ${HIGH}`);
    chart.setAttribute("preserveAspectRatio", "none");
    chart.setAttribute("aria-hidden", "true");
    const area = document.createElementNS(SVG, "path");
    area.setAttribute("class", "area");
    const line = document.createElementNS(SVG, "path");
    line.setAttribute("class", "line");
    chart.append(area, line);
    const button = Object.assign(document.createElement("button"), { type: "button", className: "chart-open", title: "Show it at full size" });
    button.append(chart);
    button.addEventListener("click", () => this.chart.open(this.#series(row), button));
    const top = Object.assign(document.createElement("p"), { className: "top" });
    const said = Object.assign(document.createElement("div"), { className: "said" });
    const odd = Object.assign(document.createElement("ul"), { className: "odd said" });
    said.append(word, detail);
    item.append(title, said, button, top);
    if (row.id === "link") item.append(odd);
    const cameras = Object.assign(document.createElement("ul"), { className: "each", hidden: true });
    if (row.id === "camera") item.append(cameras);
    this.#parts.set(row.id, { item, title, word, detail, button, line, area, top, odd, cameras });
    return item;
  }

  #add(piece) {
    this.#rows.push(...piece.items);
    if (this.#rows.length > KEPT) this.#rows = this.#rows.slice(-KEPT);
    for (const row of ROWS) {
      this.#draw(row);
      this.chart.renew(this.#series(row));
    }
  }

  #series({ id, title, unit, column }) {
    const values = this.#column(column);
    return { id, title, unit, least: 0, times: this.#column("time_s"), values };
  }

  #column(name) {
    const index = this.#columns.indexOf(name);
    return this.#rows.map((row) => row[index]);
  }

  #draw(row) {
    const { button, line, area, top } = this.#parts.get(row.id);
    const values = this.#column(row.column);
    const known = values.filter((value) => value !== null);
    const high = Math.max(row.least, niceAbove(Math.max(0, ...known)));
    const count = Math.max(SHOWN_LEAST, values.length);
    const x = (k) => WIDE - ((values.length - 1 - k) / (count - 1)) * WIDE;
    const y = (value) => HIGH - 2 - (value / high) * (HIGH - 5);
    let data = "";
    let fill = "";
    values.forEach((value, k) => {
      if (value === null) return;
      const begins = k === 0 || values[k - 1] === null;
      data += `${begins ? "M" : "L"}${x(k).toFixed(1)} ${y(value).toFixed(1)}`;
      fill += begins ? `M${x(k).toFixed(1)} ${HIGH}L${x(k).toFixed(1)} ${y(value).toFixed(1)}` : `L${x(k).toFixed(1)} ${y(value).toFixed(1)}`;
      if (k === values.length - 1 || values[k + 1] === null) fill += `L${x(k).toFixed(1)} ${HIGH}Z`;
    });
    line.setAttribute("d", data);
    area.setAttribute("d", fill);
    const last = known.at(-1);
    top.textContent = known.length ? figure(last, row.unit) : "";
    button.setAttribute("aria-label", known.length ? `${row.title}: now ${last} ${row.unit}, at most ${Math.max(...known)} in two minutes; show it at full size` : `${row.title}: nothing yet; show it at full size`);
  }

  #show(state) {
    const last = (name) => this.#column(name).at(-1) ?? null;
    for (const row of ROWS) {
      const { word, detail } = this.#parts.get(row.id);
      const judged = row.judge(state);
      word.hidden = judged === null;
      if (judged) {
        word.dataset.level = judged[0];
        if (word.textContent !== judged[1]) word.textContent = judged[1];
      }
      if (row.id === "camera") showCameras(this.#parts.get("camera"), state.camera.each);
      if (row.id === "link") showOddities(this.#parts.get("link").odd, state.link);
      const text = row.detail(state, last);
      if (detail.textContent !== text) detail.textContent = text;
      word.title = judged?.[1] ?? "";
    }
  }
}

function cameraWord({ camera }) {
  const away = camera.each.filter((one) => one.state !== "running");
  if (away.length && away.length < camera.each.length) return ["bad", `${away.length} of ${camera.each.length} away`];
  return camera.state === "running" ? ["good", "running"] : ["bad", camera.reason || camera.state];
}

function cameraDetail({ camera }) {
  const age = camera.latency_ms === null ? "" : `, ${camera.latency_ms.toFixed(0)} ms old when it arrives`;
  const again = camera.reopened ? `, opened again ${camera.reopened}×` : "";
  const rate = camera.each.length ? "" : `${camera.rate_hz.toFixed(1)} pictures/s, `;
  return `${rate}${camera.dropped} skipped${age}${again}`;
}

/** Each of several cameras with its rate, or why it gives no picture. */
function showCameras({ item, title, cameras }, each) {
  const isNew = fill(cameras, each.map((one) => one.name), () => each.map(() => Object.assign(document.createElement("li"), { className: "word" })));
  if (isNew) {
    cameras.hidden = each.length === 0;
    item.classList.toggle("has-each", each.length > 0);
    title.textContent = each.length ? "Cameras" : "Camera";
  }
  each.forEach((one, k) => {
    const runs = one.state === "running";
    const text = runs ? `${one.name}: ${one.rate_hz.toFixed(1)} pictures/s` : `${one.name}: ${one.reason || one.state}`;
    const line = cameras.children[k];
    if (line.dataset.level !== (runs ? "good" : "bad")) line.dataset.level = runs ? "good" : "bad";
    if (line.textContent !== text) line.textContent = line.title = text;
  });
}

function linkWord({ link }) {
  return link.reason ? ["bad", link.reason] : link.heard_ms > 400 ? ["warn", "slow"] : ["good", "up"];
}

function linkDetail({ link }) {
  const trip = link.round_trip_ms === null ? "–" : `${link.round_trip_ms.toFixed(0)} ms`;
  return `${trip} round trip, ${link.retransmits} sent again, ${link.crc_errors} damaged`;
}

function showOddities(list, link) {
  const met = ODDITIES.filter(([name]) => link[name] > 0).map(([name, words, title]) => ({ textContent: `${link[name]} ${words}`, title }));
  fill(list, met, () => met.map((one) => Object.assign(document.createElement("li"), one)));
}

function plannerWord({ times }) {
  return times.roadmap_ms === null ? ["warn", "waiting for a scene"] : ["good", "ready"];
}

function both(one, first, other, second) {
  return `${figure(one, first)}, ${figure(other, second)}`;
}

function figure(value, unit) {
  if (value === null || value === undefined) return `– ${unit}`;
  return `${value >= 100 ? value.toFixed(0) : value >= 10 ? value.toFixed(1) : value.toFixed(2)} ${unit}`;
}

function niceAbove(value) {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  const steps = [1, 1.5, 2, 3, 5, 7.5, 10].map((m) => m * power);
  return Number(steps.find((step) => step >= value * 0.999).toPrecision(3));
}
