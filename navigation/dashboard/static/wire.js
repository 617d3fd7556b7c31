// Packed messages: a length, a JSON head, arrays; see navigation/dashboard/messages/packed.py.

const TYPES = { float32: Float32Array, int32: Int32Array, uint8: Uint8Array };

/** Head and arrays of a binary message, without copying. */
export function unpack(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const arrays = {};
  for (const [name, [type, first, count]] of Object.entries(head.arrays)) {
    arrays[name] = new TYPES[type](buffer, 4 + length + first, count);
  }
  return { ...head, arrays };
}
