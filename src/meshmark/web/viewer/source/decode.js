// A view as it is sent: one JSON object with base64 typed arrays. What is not as announced is an error.

/** Bytes of a base64 text. */
function bytes(text) {
  const raw = atob(text);
  const out = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) out[i] = raw.charCodeAt(i);
  return out;
}

const TYPES = { uint8: Uint8Array, uint16: Uint16Array, uint32: Uint32Array };

/** A typed array of `count` little-endian numbers; `packed` is {type, data}. */
export function unpack(packed, count, what) {
  const Type = TYPES[packed.type];
  if (!Type) throw new Error(`${what} are of type ${packed.type}, expected uint8, uint16 or uint32`);
  const raw = bytes(packed.data);
  if (raw.length !== count * Type.BYTES_PER_ELEMENT) {
    throw new Error(`${what} take ${raw.length} bytes, expected ${count * Type.BYTES_PER_ELEMENT}`);
  }
  return new Type(raw.buffer);
}

/** {positions: Float32Array (3n), triangles: Uint32Array (3m)} of a view; x is right, y up, z towards the viewer. */
export function decodeSurface(view) {
  const packed = unpack(view.positions, 3 * view.vertices, "positions");
  const triangles = unpack(view.triangles, 3 * view.faces, "triangles");
  const positions = new Float32Array(packed.length);
  const { low, high } = view.box;
  for (let i = 0; i < packed.length; i++) {
    const axis = i % 3;
    positions[i] = low[axis] + (packed[i] / 65535) * (high[axis] - low[axis]);
  }
  return { positions, triangles };
}
