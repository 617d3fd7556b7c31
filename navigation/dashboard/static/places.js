// Saved places: used as a goal or a station, saved, renamed, removed; the same for everybody.

import { fill } from "./list.js";

export class Places {
  #places = [];
  /** The place whose name is being changed, or "". */
  #renamed = "";
  #robot = null;

  constructor(connection, goal, seat, say) {
    Object.assign(this, { connection, goal, seat, say });
    this.list = document.getElementById("places-list");
    this.form = document.getElementById("places-form");
    this.name = document.getElementById("places-name");
    this.button = document.getElementById("places-save");
    this.cancel = document.getElementById("places-cancel");
    this.note = document.getElementById("places-note");
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.#submit();
    });
    this.cancel.addEventListener("click", () => this.#rename(""));
    connection.on("places", ({ places }) => { this.#places = places; this.#show(); });
    connection.on("state", (state) => { this.#robot = state.pose; });
  }

  async #ask(message) {
    const answer = await this.connection.ask({ type: "place", ...message });
    this.say(answer.ok ? "" : answer.error);
    return answer.ok;
  }

  async #submit() {
    const name = this.name.value.trim();
    if (!name) {
      this.note.textContent = "Give it a name first.";
      this.name.focus();
      return;
    }
    const renamed = this.#renamed;
    if (renamed) {
      if (!(await this.#ask({ do: "rename", name: renamed, to: name }))) return;
      this.#rename("");
      this.note.textContent = `${renamed} is now ${name}.`;
      return;
    }
    const robot = this.#robot && { x_m: this.#robot.x_m, y_m: this.#robot.y_m, heading_rad: this.#robot.heading_rad };
    const station = this.goal.last ?? robot;
    if (!station) {
      this.note.textContent = "Nothing to save: there is no new goal, and the robot is not seen.";
      return;
    }
    if (!(await this.#ask({ do: "save", name, station }))) return;
    this.note.textContent = `${name} is saved, ${this.goal.last ? "where the new goal is" : "where the robot is"}.`;
    this.name.value = "";
  }

  async #remove(place) {
    if (!(await this.#ask({ do: "remove", name: place.name }))) return;
    this.#rename("");
    const undo = Object.assign(document.createElement("button"), { type: "button", className: "quiet link", textContent: "Undo" });
    undo.addEventListener("click", async () => {
      const { name, x_m, y_m, heading_rad } = place;
      if (await this.#ask({ do: "save", name, station: { x_m, y_m, heading_rad } })) this.note.textContent = `${name} is back.`;
    });
    this.note.replaceChildren(`${place.name} is removed. `, undo);
    undo.focus();
  }

  #rename(name) {
    this.#renamed = name;
    this.name.value = name;
    this.button.textContent = name ? "Rename" : "Save";
    this.cancel.hidden = !name;
    this.note.textContent = name ? `A new name for ${name}.` : "";
    if (name) this.name.select();
  }

  #show() {
    document.getElementById("places-none").hidden = this.#places.length > 0;
    fill(this.list, this.#places, () => this.#places.map((place) => {
      const item = document.createElement("li");
      const turned = place.heading_rad === null ? "" : `, ${Math.round((place.heading_rad * 180) / Math.PI)}°`;
      const use = button(place.name, "use quiet", `Set ${place.name} as the goal`, () => this.goal.use(place));
      use.append(Object.assign(document.createElement("small"), { textContent: `${place.x_m.toFixed(2)}, ${place.y_m.toFixed(2)} m${turned}` }));
      item.append(
        use,
        button("Rename", "quiet small", `Rename ${place.name}`, () => this.#rename(place.name)),
        button("×", "quiet small", `Remove ${place.name}`, () => this.#remove(place)),
      );
      return item;
    }));
  }
}

function button(text, className, label, act) {
  const made = Object.assign(document.createElement("button"), { type: "button", className, textContent: text, title: label });
  made.setAttribute("aria-label", label);
  made.addEventListener("click", act);
  return made;
}
