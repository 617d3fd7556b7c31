// Lists whose parts a person may hold: a button under a finger, a field with the focus.

const shown = new WeakMap();

/** Fill a list with the parts for `what`; they stay if they are for the same already. True if made. */
export function fill(list, what, make) {
  const text = JSON.stringify(what);
  if (shown.get(list) === text) return false;
  shown.set(list, text);
  list.replaceChildren(...make());
  return true;
}
