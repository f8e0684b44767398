// What gable packed into the page: see src/view/payload.rs.

/** A reader of integers in LEB128. */
export class Reader {
  constructor(bytes) {
    this.bytes = bytes;
    this.at = 0;
  }

  /** The next number. */
  next() {
    const { bytes } = this;
    let byte = bytes[this.at++];
    let value = byte & 0x7f;
    // Shifts would end at 32 bits.
    for (let scale = 128; byte > 0x7f; scale *= 128) {
      byte = bytes[this.at++];
      value += (byte & 0x7f) * scale;
    }
    return value;
  }

  /** The next number of either sign. */
  signed() {
    return unfold(this.next());
  }

  /** How many numbers there are in all. */
  count() {
    let count = 0;
    for (const byte of this.bytes) {
      count += byte < 0x80 ? 1 : 0;
    }
    return count;
  }
}

/** 0, 1, 2, 3, … as 0, -1, 1, -2, … */
export const unfold = (number) => (number % 2 === 0 ? number / 2 : -(number + 1) / 2);

function fromBase64(text) {
  if (Uint8Array.fromBase64) {
    return Uint8Array.fromBase64(text);
  }
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i += 1) {
    bytes[i] = binary.charCodeAt(i);
  }
  return bytes;
}

/** The head and the columns, each a `Reader`. */
export async function unpack(text) {
  if (typeof DecompressionStream === 'undefined') {
    throw new Error('this browser is too old to unpack the model: it has no DecompressionStream');
  }
  const stream = new Blob([fromBase64(text.trim())]).stream().pipeThrough(new DecompressionStream('deflate-raw'));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const length = new DataView(bytes.buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
  const columns = {};
  let at = 4 + length;
  for (const [name, size] of head.columns) {
    columns[name] = new Reader(bytes.subarray(at, at + size));
    at += size;
  }
  return { head, columns };
}
