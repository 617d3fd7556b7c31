// The page: wires its parts.

import { Calibration } from "./calibration.js";
import { Connection } from "./connection.js";
import { Fleet } from "./fleet.js";
import { Goal } from "./goal.js";
import { Health } from "./health.js";
import { History } from "./history.js";
import { LAYERS, Layers } from "./layers.js";
import { Log } from "./log.js";
import { MissionPanel } from "./mission.js";
import { Panel } from "./panel.js";
import { Picture } from "./picture.js";
import { Places } from "./places.js";
import { Replay } from "./replay.js";
import { Robots } from "./robots.js";
import { RobotsLayer } from "./robots_layer.js";
import { Seat } from "./seat.js";
import { Settings } from "./settings.js";
import { Stage } from "./stage.js";
import { Stop } from "./stop.js";
import { View } from "./view.js";
import { Zones } from "./zones.js";
import { ZonesLayer } from "./zones_layer.js";

const byId = (id) => document.getElementById(id);
const connection = new Connection();
const fleet = new Fleet(connection);
const stage = new Stage();
const view = new View(stage);
const [keys] = ["keys", "layers", "legend"].map((name) => new Panel(name));
const history = new History(connection);
const seat = new Seat(connection, say);
const stop = new Stop(connection, seat, say);
const picture = new Picture(stage, connection);
const layers = new Layers(stage, picture, connection);
const zonesLayer = new ZonesLayer(stage, connection);
new RobotsLayer(stage, connection, fleet); // before the goal, which hears presses in the arena, too
const goal = new Goal(stage, connection, seat, say);
const zones = new Zones(stage, connection, seat, layers, zonesLayer, fleet);
const replay = new Replay(connection, say);
new MissionPanel(connection, seat, say);
const health = new Health(connection);
new Robots(connection, fleet, seat, say);
connection.on("chosen", () => { goal.clear(); say(""); }); // they were another robot's
new Log(connection);
const settings = new Settings(connection, seat);
const calibration = new Calibration(connection, seat);
new Places(connection, goal, seat, say);

// The last refusal, until the next order.
function say(text) {
  byId("refusal").hidden = byId("refusal-close").hidden = !text;
  if (text) byId("said").scrollTop = 0; // it stands first
  byId("refusal-text").textContent = text ? text[0].toUpperCase() + text.slice(1) + (/[.!?]$/.test(text) ? "" : ".") : "";
}
byId("refusal-close").addEventListener("click", () => say(""));

// The connection, in the bar and across the page.
connection.on("state", (state) => {
  if (state.replay) {
    pill("calm", "recording");
    return;
  }
  const hangs = state.loop_ms === null || state.loop_ms > 1000;
  pill(hangs ? "bad" : "good", hangs ? "control loop hangs" : "live");
});
connection.on("up", () => {
  byId("lost").hidden = true;
  askForToken(false);
  document.body.classList.remove("is-lost");
});
connection.on("down", () => {
  pill("bad", "no connection");
  document.body.classList.add("is-lost");
  byId("lost").hidden = !byId("token-form").hidden;
  const since = connection.lostSeconds;
  const said = connection.lostReason ? `The program said: ${connection.lostReason}. ` : "";
  byId("lost-text").textContent = `${said}${said ? "For" : "for"} ${since} s. What you see is old, and orders from here do not arrive. The robot stops by itself when the program has ended.`;
  document.title = "No connection – Clearway";
});
connection.on("token", (status) => {
  byId("lost").hidden = true;
  askForToken(true);
  if (status === 403) byId("token").setCustomValidity("");
});
byId("token-form").addEventListener("submit", (event) => {
  event.preventDefault();
  askForToken(false);
  connection.useToken(byId("token").value.trim());
});

function askForToken(on) {
  byId("token-form").hidden = byId("token-note").hidden = !on;
}

function pill(level, text) {
  byId("pill").dataset.state = level;
  if (byId("pill-text").textContent !== text) byId("pill-text").textContent = text;
}

// Light or dark: as the system has it, until it is chosen here.
const theme = localStorage.getItem("clearway.theme");
if (theme) document.documentElement.dataset.theme = theme;
byId("theme").addEventListener("click", () => {
  const isDark = getComputedStyle(document.documentElement).colorScheme === "dark";
  document.documentElement.dataset.theme = isDark ? "light" : "dark";
  localStorage.setItem("clearway.theme", document.documentElement.dataset.theme);
});

// Keys for everywhere but text fields; the space bar is stop.js's.
addEventListener("keydown", (event) => {
  if (event.target.matches("input:not([type=checkbox]), select, textarea") || event.ctrlKey || event.metaKey || event.altKey) return;
  if (fleet.key(event)) return;
  const layer = LAYERS[Number(fleet.areSeveral ? event.shiftKey && event.code.replace("Digit", "") : event.key) - 1];
  if (replay.key(event)) event.preventDefault();
  else if (layer) layers.toggle(layer);
  else if (event.key === "?") keys.toggle();
  else if (event.key === "z" || event.key === "Z") zones.toggle();
  else if (event.key === "h" || event.key === "H") history.toggle();
  else if (event.key === "+" || event.key === "=") view.zoom(1.4);
  else if (event.key === "-") view.zoom(1 / 1.4);
  else if (event.key === "0") stage.show(null);
  else if (event.key === "Escape" && Panel.open) Panel.open.close();
  else if (event.key === "Escape" && settings.isOpen) settings.close();
  else if (event.key === "Escape" && calibration.isOpen) calibration.close();
  else if (event.key === "Escape" && health.chart.isOpen) health.chart.close();
  else if (event.key === "Escape" && zones.isOpen) zones.escape();
  else if (event.key === "Escape") goal.clear();
  else if (event.key === "t" || event.key === "T") seat.toggle();
  else if (event.key === "Enter" && !event.target.matches("button, a, input")) (zones.isOpen ? zones.enter() : goal.submit());
});

connection.open();
Object.assign(globalThis, { clearway: { connection, fleet, picture, stop, stage, zones } }); // for a look from the console
