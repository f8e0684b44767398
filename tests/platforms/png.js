// Pictures of few colours: a page has few, and what else is in it can do with them.
'use strict';

const zlib = require('node:zlib');

/** The pixels of a screenshot: width, height, and red, green, blue, alpha of each. */
async function pixelsOf(page) {
  const png = await page.screenshot({ encoding: 'base64' });
  const blank = await page.browser().newPage();
  const { width, height, data } = await blank.evaluate(async (png) => {
    const image = new Image();
    image.src = `data:image/png;base64,${png}`;
    await image.decode();
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    const parts = [];
    for (let i = 0; i < data.length; i += 0x8000) {
      parts.push(String.fromCharCode(...data.subarray(i, i + 0x8000)));
    }
    return { width: image.width, height: image.height, data: btoa(parts.join('')) };
  }, png);
  await blank.close();
  return { width, height, data: Buffer.from(data, 'base64') };
}

/** The 256 colours that are most of a picture, in steps of 8 of each channel, and of every such step the nearest of them. */
function paletteOf(data) {
  const boxes = new Map();
  for (let i = 0; i < data.length; i += 4) {
    const key = ((data[i] >> 3) << 10) | ((data[i + 1] >> 3) << 5) | (data[i + 2] >> 3);
    const box = boxes.get(key) ?? { key, count: 0, sum: [0, 0, 0] };
    box.count += 1;
    box.sum.forEach((_, channel) => (box.sum[channel] += data[i + channel]));
    boxes.set(key, box);
  }
  const all = [...boxes.values()].sort((a, b) => b.count - a.count);
  all.forEach((box) => (box.colour = box.sum.map((sum) => Math.round(sum / box.count))));
  const colours = all.slice(0, 256).map(({ colour }) => colour);
  const far = (a, b) => a.reduce((sum, value, channel) => sum + (value - b[channel]) ** 2, 0);
  const nearest = ({ colour }) =>
    colours.reduce((best, own, i) => (far(own, colour) < far(colours[best], colour) ? i : best), 0);
  return { colours, index: new Map(all.map((box) => [box.key, nearest(box)])) };
}

/** The check sum of a part of a PNG; that of zlib is in no node before 20.15. */
function sumOf(bytes) {
  let sum = 0xffffffff;
  for (const byte of bytes) {
    sum ^= byte;
    for (let bit = 0; bit < 8; bit += 1) {
      sum = sum & 1 ? (sum >>> 1) ^ 0xedb88320 : sum >>> 1;
    }
  }
  return ~sum >>> 0;
}

function chunk(type, data) {
  const body = Buffer.concat([Buffer.from(type, 'latin1'), data]);
  const out = Buffer.alloc(body.length + 8);
  out.writeUInt32BE(data.length);
  body.copy(out, 4);
  out.writeUInt32BE(sumOf(body), body.length + 4);
  return out;
}

/** What a page shows as a PNG with a palette. */
async function indexed(page) {
  const { width, height, data } = await pixelsOf(page);
  const { colours, index } = paletteOf(data);
  const rows = Buffer.alloc((width + 1) * height);
  for (let i = 0; i < width * height; i += 1) {
    const key = ((data[i * 4] >> 3) << 10) | ((data[i * 4 + 1] >> 3) << 5) | (data[i * 4 + 2] >> 3);
    rows[Math.floor(i / width) + 1 + i] = index.get(key);
  }
  const header = Buffer.alloc(13);
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  // Eight bits, with a palette.
  header.set([8, 3, 0, 0, 0], 8);
  return Buffer.concat([
    Buffer.from('89504e470d0a1a0a', 'hex'),
    chunk('IHDR', header),
    chunk('PLTE', Buffer.from(colours.flat())),
    chunk('IDAT', zlib.deflateSync(rows, { level: 9 })),
    chunk('IEND', Buffer.alloc(0)),
  ]);
}

module.exports = { indexed };
