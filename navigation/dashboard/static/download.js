// Files of earlier runs, fetched in pieces with the page's token.

const PIECE = 524288;

/** A whole file as a Blob; `tell` gets the share fetched, 0 to 1. Throws an Error in words. */
export async function fetchFile(connection, address, type, tell = () => {}) {
  const parts = [];
  let here = 0;
  let size = Infinity;
  while (here < size) {
    const answer = await ask(address, { ...connection.authorization, Range: `bytes=${here}-${here + PIECE - 1}` });
    if (answer.status === 416 && here === 0) return new Blob([], { type }); // an empty file
    if (answer.status !== 206) throw new Error((await answer.text()).trim() || `the program answered ${answer.status}`);
    const piece = await answer.blob();
    if (!piece.size) throw new Error("the file has become shorter meanwhile");
    // a file that grows while it is fetched ends where it ended at first
    if (size === Infinity) size = Number(answer.headers.get("content-range")?.split("/")[1]);
    parts.push(piece);
    here += piece.size;
    tell(Math.min(1, here / size));
  }
  return new Blob(parts, { type });
}

/** The answer of an address; throws an Error in words. */
export async function ask(address, headers) {
  try {
    return await fetch(address, { headers, signal: AbortSignal.timeout(15000) });
  } catch {
    throw new Error("the program does not answer");
  }
}

/** Have the browser save a Blob under a name. */
export function save(blob, name) {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

/** A size as people read it. */
export function inBytes(count) {
  if (count < 1000) return `${count} bytes`;
  const power = Math.min(3, Math.floor(Math.log10(count) / 3));
  const value = count / 1000 ** power;
  return `${value < 10 ? value.toFixed(1) : value.toFixed(0)} ${["", "kB", "MB", "GB"][power]}`;
}
