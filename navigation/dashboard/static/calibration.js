// The camera's lens calibrated from the page: the board's numbers, the picture with what is still needed,
// and what came of it. It is not modal: STOP stays where it is, and works.

import { drawBoardView } from "./board.js";
import { allow, onPress } from "./press.js";
import { request } from "./request.js";

const ADDRESS = "/api/calibration";
const ASK_EVERY_MS = 150;
const byId = (id) => document.getElementById(id);
const upper = (text) => text.slice(0, 1).toUpperCase() + text.slice(1);
const FIELDS = ["kind", "squares", "square_mm", "marker_mm", "dictionary"];

export class Calibration {
  #timer = 0;
  #frame = null;
  #answered = "";

  constructor(connection, seat) {
    Object.assign(this, { connection, seat });
    this.box = byId("calibration");
    this.open = byId("calibration-open");
    this.open.addEventListener("click", () => this.toggle());
    byId("calibration-close").addEventListener("click", () => this.close());
    for (const name of FIELDS) {
      const kept = localStorage.getItem(`clearway.board.${name}`);
      if (kept !== null) byId(`board-${name}`).value = kept;
    }
    byId("board-kind").addEventListener("change", () => this.#showKind());
    this.#showKind();
    onPress(byId("calibration-start"), (text) => this.#say(text), () => this.#start());
    onPress(byId("calibration-save"), (text) => this.#say(text), () => this.#order("save"));
    onPress(byId("calibration-cancel"), (text) => this.#say(text), () => this.#order("cancel"));
    connection.on("hello", () => { this.open.hidden = !seat.mayDrive; });
  }

  get isOpen() {
    return !this.box.hidden;
  }

  toggle() {
    this.box.hidden = !this.box.hidden;
    this.open.setAttribute("aria-expanded", String(this.isOpen));
    clearTimeout(this.#timer);
    if (this.isOpen) {
      byId("calibration-close").focus();
      this.#answered = "";
      this.#ask();
    } else {
      this.open.focus();
    }
  }

  close() {
    if (this.isOpen) this.toggle();
  }

  async #ask() {
    clearTimeout(this.#timer);
    const told = await request(this.connection, ADDRESS);
    if (!this.isOpen) return;
    if (told.ok) await this.#show(told);
    else this.#refuse(told.error);
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#ask(), ASK_EVERY_MS);
  }

  #refuse(error) {
    byId("calibration-board").hidden = byId("calibration-view").hidden = true;
    byId("calibration-save").hidden = byId("calibration-cancel").hidden = true;
    this.#say(error);
  }

  async #show(told) {
    const isIdle = told.phase === "idle";
    byId("calibration-board").hidden = !isIdle || told.refusal !== "";
    byId("calibration-view").hidden = isIdle || told.state === null;
    byId("calibration-cancel").hidden = isIdle;
    byId("calibration-save").hidden = told.phase !== "found";
    allow(byId("calibration-save"), "");
    const fitting = told.phase === "fitting" ? "enough views: the lens is being fitted" : "";
    const sentence = told.phase === "taking" ? told.state?.sentence ?? "waiting for a picture" : "";
    this.#say(told.refusal || this.#answered || fitting || told.said || sentence);
    if (told.state && told.state.frame !== this.#frame && !isIdle) await this.#draw(told);
  }

  async #draw({ state, remarks }) {
    this.#frame = state.frame;
    const answer = await fetch(`${ADDRESS}/picture.jpg?frame=${state.frame}`, { headers: { ...this.connection.authorization } }).catch(() => null);
    if (!answer?.ok) return;
    const picture = byId("calibration-picture");
    const before = picture.src;
    picture.src = URL.createObjectURL(await answer.blob());
    await picture.decode().catch(() => undefined);
    if (before) URL.revokeObjectURL(before);
    drawBoardView(byId("calibration-frame"), byId("calibration-overlay"), state);
    const lines = [state.board.replace(/^board: /, "the board is "), state.parts, `largest spread ${state.spread} of ${state.limit_px} px wanted`, state.focal, `${state.count} ${state.count === 1 ? "view" : "views"}`];
    byId("calibration-known").textContent = `${lines.map(upper).join(". ")}.`;
    byId("calibration-still").value = state.still;
    byId("calibration-last").textContent = remarks.length ? upper(remarks.at(-1)) : "";
  }

  async #start() {
    const board = Object.fromEntries(FIELDS.map((name) => [name, byId(`board-${name}`).value]));
    for (const name of FIELDS) localStorage.setItem(`clearway.board.${name}`, board[name]);
    await this.#order("start", board);
  }

  async #order(what, body = {}) {
    const taken = what === "cancel" ? { ok: true } : await this.seat.takeIfFree();
    const answer = taken.ok ? await request(this.connection, `${ADDRESS}/${what}`, { ...body, key: this.connection.key }) : taken;
    this.#answered = answer.ok ? "" : answer.error;
    await this.#ask();
  }

  #showKind() {
    const isChessboard = byId("board-kind").value === "chessboard";
    for (const one of this.box.querySelectorAll(".of-charuco")) one.hidden = isChessboard;
  }

  #say(text) {
    const said = text ? upper(text) + (/[.!?]$/.test(text) ? "" : ".") : "";
    if (byId("calibration-said").textContent !== said) byId("calibration-said").textContent = said;
  }
}
