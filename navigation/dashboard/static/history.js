// Earlier runs, newest first, and what the chosen one left behind. Nothing is asked for before it is
// opened.

import { ask, fetchFile, inBytes, save } from "./download.js";

const A_PAGE = 20;
const WORDS = { done: "Arrived", failed: "Failed", stopped: "Stopped" };
const FILE_WORDS = { "report.json": "Report", "track.svg": "Picture of the track", "events.jsonl": "Log of events" };
/** Figures of a report: their words, and their text. */
const FIGURES = [
  ["Stations visited", (r) => `${r.stations_visited} of ${r.stations}`],
  ["Duration", (r) => duration(r.duration_s)],
  ["Least clearance", (r) => figure(r.min_clearance_m, 3, "m")],
  ["Off the plan at most", (r) => figure(r.tracking_error_m?.max, 3, "m")],
  ["Off the goal", (r) => figure(r.goal_error_m, 3, "m")],
  ["Off its heading", (r) => figure(r.goal_error_deg, 1, "°")],
  ["Plans made again", (r) => figure(r.replans, 0, "")],
  ["Picture to command, median", (r) => figure(r.latency_ms?.capture_to_wire?.p50, 1, "ms")],
  ["Picture to command, 99 of 100", (r) => figure(r.latency_ms?.capture_to_wire?.p99, 1, "ms")],
  ["Pictures", (r) => `${figure(r.frames?.processed, 0, "")}, ${figure(r.frames?.dropped, 0, "dropped")}`],
  ["Sent again on the link", (r) => figure(r.link?.retransmits, 0, "")],
];
/** The same of a run of several robots, and of each of them. */
const ALL_FIGURES = [
  ["Duration", (r) => duration(r.duration_s)],
  ["Least gap", (r) => figure(r.least_gap_m, 3, "m") + (Array.isArray(r.least_gap_between) ? `, ${r.least_gap_between.join(" and ")}` : "")],
  ["Least clearance", (r) => figure(r.min_clearance_m, 3, "m")],
  ["Planned together", (r) => (r.rounds === 1 ? "once" : `${figure(r.rounds, 0, "")} times`)],
];
const EACH = [
  ["How it ended", (r) => WORDS[r.state] ?? "–"],
  ["Stations", (r) => `${figure(r.stations_visited, 0, "")} of ${figure(r.stations, 0, "")}`],
  ["Clearance", (r) => figure(r.min_clearance_m, 3, "m")],
  ["Off the plan", (r) => figure(r.tracking_error_m?.max, 3, "m")],
  ["Off the goal", (r) => figure(r.goal_error_m, 3, "m")],
  ["To wire, median", (r) => figure(r.latency_ms?.capture_to_wire?.p50, 1, "ms")],
];

export class History {
  #runs = [];
  #chosen = "";
  #picture = "";

  constructor(connection) {
    this.connection = connection;
    this.box = document.getElementById("history-box");
    this.list = document.getElementById("history-list");
    this.detail = document.getElementById("history-detail");
    this.note = document.getElementById("history-note");
    this.more = document.getElementById("history-more");
    this.button = document.getElementById("history-open");
    this.button.addEventListener("click", () => this.toggle());
    this.more.addEventListener("click", () => this.#load(this.#runs.at(-1)?.name));
    document.getElementById("history-again").addEventListener("click", () => this.#load());
  }

  get isOpen() {
    return !this.box.hidden;
  }

  async toggle() {
    this.box.hidden = this.isOpen;
    this.button.textContent = this.isOpen ? "Hide" : "Show";
    this.button.setAttribute("aria-expanded", String(this.isOpen));
    if (!this.isOpen) return;
    this.button.focus({ preventScroll: true });
    await this.#load();
    document.getElementById("history").scrollIntoView({ block: "start" });
  }

  async #load(before = null) {
    this.#say("Reading…");
    const query = new URLSearchParams({ count: A_PAGE, ...(before ? { before } : {}) });
    try {
      const answer = await ask(`/api/runs?${query}`, this.connection.authorization);
      if (!answer.ok) throw new Error((await answer.text()).trim());
      const page = await answer.json();
      this.#runs = before ? [...this.#runs, ...page.runs] : page.runs;
      this.more.hidden = !page.following;
      this.#say(page.total ? `${this.#runs.length} of ${page.total} ${page.total === 1 ? "run" : "runs"}` : "No run has left anything behind yet.");
      this.#showList();
    } catch (error) {
      this.#say(`The runs could not be read: ${error.message}.`);
    }
  }

  #say(text) {
    this.note.textContent = text;
  }

  #showList() {
    this.list.replaceChildren(...this.#runs.map((run) => {
      const button = make("button", "run quiet", "");
      button.type = "button";
      button.append(
        make("span", "when", when(run.began)),
        make("span", `what ${run.state ?? ""}`, word(run)),
        make("span", "long", run.duration_s === null ? "" : duration(run.duration_s)),
        make("span", "size", inBytes(bytes(run))),
      );
      const has = [run.robots.length ? `${run.robots.length} robots` : "", run.recordings.length ? "recorded" : ""].filter(Boolean);
      if (has.length) button.append(make("span", "has", has.join(", ")));
      button.setAttribute("aria-pressed", String(run.name === this.#chosen));
      button.addEventListener("click", () => this.#choose(run, button));
      const item = document.createElement("li");
      item.append(button);
      return item;
    }));
  }

  async #choose(run, button) {
    this.#chosen = run.name;
    for (const other of this.list.querySelectorAll("button")) other.setAttribute("aria-pressed", String(other === button));
    URL.revokeObjectURL(this.#picture);
    const title = make("h3", "", `${when(run.began)}: ${word(run).toLowerCase()}`);
    title.tabIndex = -1;
    const parts = [title];
    if (run.reason) parts.push(make("p", "reason", run.robots.length ? run.reason : sentence(run.reason)));
    const figures = make("dl", "figures", "");
    const picture = make("figure", "track-picture", "");
    parts.push(figures, picture, this.#files(run));
    this.detail.replaceChildren(...parts);
    this.detail.hidden = false;
    if (this.detail.offsetTop > this.list.offsetTop) title.focus(); // it is below the list, not beside it
    await Promise.all([this.#showReport(run, figures), this.#showPicture(run, picture)]);
  }

  async #showReport(run, box) {
    if (!run.files.some((file) => file.name === "report.json")) {
      box.replaceWith(make("p", "hint", run.running ? "It has no report before it ends." : "It left no report: the program was ended by force, or the disk was full."));
      return;
    }
    try {
      const report = JSON.parse(await (await fetchFile(this.connection, address(run, "report.json"), "")).text());
      if (this.#chosen !== run.name) return;
      const areSeveral = report.robots !== null && typeof report.robots === "object";
      box.replaceChildren(...(areSeveral ? ALL_FIGURES : FIGURES).map(([words, text]) => {
        const row = document.createElement("div");
        row.append(make("dt", "", words), make("dd", "", text(report)));
        return row;
      }));
      if (areSeveral) box.after(eachRobot(report.robots));
    } catch (error) {
      box.replaceWith(make("p", "hint", `The report could not be read: ${error.message}.`));
    }
  }

  async #showPicture(run, box) {
    if (!run.files.some((file) => file.name === "track.svg")) {
      box.hidden = true;
      return;
    }
    try {
      const blob = await fetchFile(this.connection, address(run, "track.svg"), "image/svg+xml");
      if (this.#chosen !== run.name) return;
      this.#picture = URL.createObjectURL(blob);
      box.append(Object.assign(document.createElement("img"), { src: this.#picture, alt: "The arena with the plan and the driven track" }));
    } catch (error) {
      box.append(make("figcaption", "hint", `The picture could not be read: ${error.message}.`));
    }
  }

  #files(run) {
    const list = make("ul", "files", "");
    for (const file of [...run.files, ...run.recordings]) {
      const item = document.createElement("li");
      const words = FILE_WORDS[file.name] ?? "Recording";
      const button = make("button", "quiet", "Save");
      button.type = "button";
      button.setAttribute("aria-label", `Save ${file.name}`);
      const state = make("span", "size", inBytes(file.bytes));
      button.addEventListener("click", () => this.#save(run, file, state));
      const name = make("span", "file", words);
      name.append(make("small", "", file.name));
      item.append(name, state, button);
      list.append(item);
    }
    return list;
  }

  async #save(run, file, state) {
    state.setAttribute("role", "status");
    try {
      const type = "application/octet-stream"; // to be saved, not opened
      const blob = await fetchFile(this.connection, address(run, file.name), type, (part) => {
        state.textContent = `${Math.floor(100 * part)} %`;
      });
      save(blob, file.name.startsWith("clearway_") ? file.name : `${run.name}_${file.name}`);
      state.textContent = inBytes(blob.size);
    } catch (error) {
      state.textContent = `not saved: ${error.message}`;
    }
  }
}

function make(name, className, textContent) {
  return Object.assign(document.createElement(name), { className, textContent });
}

/** A table with a row for each robot, its number and colour as on the rest of the page. */
function eachRobot(robots) {
  const head = document.createElement("tr");
  head.append(...["Robot", ...EACH.map(([words]) => words)].map((words) => Object.assign(make("th", "", words), { scope: "col" })));
  const rows = Object.entries(robots).map(([name, report], index) => {
    const row = document.createElement("tr");
    const title = Object.assign(make("th", "", ""), { scope: "row" });
    title.append(make("span", `chip own-${index % 8}`, String(index + 1)), make("span", "", name));
    row.append(title, ...EACH.map(([, text]) => make("td", "", text(report ?? {}))));
    row.children[1].className = `what ${report?.state ?? ""}`;
    return row;
  });
  const table = document.createElement("table");
  const [top, body] = [document.createElement("thead"), document.createElement("tbody")];
  top.append(head);
  body.append(...rows);
  table.append(top, body);
  const box = make("div", "each-robot", "");
  box.tabIndex = 0; // it scrolls where the page is narrow
  box.setAttribute("role", "region");
  box.setAttribute("aria-label", "Each robot");
  box.append(table);
  return box;
}

const address = (run, file) => `/api/runs/${run.name}/${file}`;
const bytes = (run) => [...run.files, ...run.recordings].reduce((sum, file) => sum + file.bytes, 0);
const word = (run) => (run.running ? "Under way" : WORDS[run.state] ?? run.state ?? "No report");
const sentence = (text) => text[0].toUpperCase() + text.slice(1) + (/[.!?]$/.test(text) ? "" : ".");

function when(began) {
  return new Date(began).toLocaleString([], { dateStyle: "medium", timeStyle: "medium", hour12: false });
}

function duration(seconds) {
  if (typeof seconds !== "number") return "–";
  const whole = Math.round(seconds);
  const [h, m, s] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  return h ? `${h} h ${m} min` : m ? `${m} min ${s} s` : `${s} s`;
}

function figure(value, digits, unit) {
  return typeof value === "number" ? `${value.toFixed(digits)} ${unit}`.trim() : "–";
}
