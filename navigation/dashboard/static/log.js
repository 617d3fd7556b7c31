// The log, newest first.

const KEPT = 200;

export class Log {
  #next = 0;
  #newest = "";
  /** Greeted since the last lines: the next ones are here already, or another run's. */
  #isGreeted = false;

  constructor(connection) {
    this.list = document.getElementById("log");
    this.filter = document.getElementById("log-filter");
    this.filter.value = localStorage.getItem("clearway.log") ?? "all";
    this.list.dataset.only = this.filter.value;
    this.filter.addEventListener("change", () => {
      localStorage.setItem("clearway.log", this.filter.value);
      this.list.dataset.only = this.filter.value;
    });
    connection.on("hello", () => { this.#isGreeted = true; });
    connection.on("log", (piece) => this.#hear(piece));
  }

  #hear({ first, items }) {
    const known = this.#isGreeted ? this.#next - first : 0;
    const isSame = known > 0 && String(items[known - 1]) === this.#newest;
    if (this.#isGreeted && !isSame) this.list.replaceChildren();
    this.#isGreeted = false;
    for (const line of items.slice(isSame ? known : 0)) this.#add(line);
    this.#next = first + items.length;
    this.#newest = String(items.at(-1));
  }

  #add([seconds, level, text]) {
    const item = document.createElement("li");
    item.dataset.level = level;
    const time = document.createElement("time");
    time.textContent = new Date(seconds * 1000).toLocaleTimeString([], { hour12: false });
    time.dateTime = new Date(seconds * 1000).toISOString();
    const words = document.createElement("span");
    words.textContent = text;
    item.append(time, words);
    this.list.prepend(item);
    while (this.list.children.length > KEPT) this.list.lastElementChild.remove();
  }
}
