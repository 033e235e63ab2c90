// Measures every figure of the page and writes what is wrong with it into #measured.
const FRAME = '#6E6E6E';
const wrong = [];
let curves = 0;

const outside = (inner, outer, room) =>
  inner.left < outer.left - room || inner.right > outer.right + room ||
  inner.top < outer.top - room || inner.bottom > outer.bottom + room;
const overlap = (a, b, room) =>
  Math.min(a.right, b.right) - Math.max(a.left, b.left) > room &&
  Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > room;

function measure(svg, name) {
  const whole = svg.getBoundingClientRect();
  if (whole.width < 200 || whole.height < 80) wrong.push(`${name}: ${whole.width} x ${whole.height}`);
  const texts = [...svg.querySelectorAll('text')].filter(it => it.textContent.trim());
  const boxes = texts.map(it => [it.textContent.trim(), it.getBoundingClientRect()]);
  const plots = [...svg.querySelectorAll(`rect[stroke="${FRAME}"]`)].map(it => it.getBoundingClientRect());
  if (!plots.length) wrong.push(`${name}: no plot`);
  boxes.forEach(([text, box], i) => {
    if (outside(box, whole, 1)) wrong.push(`${name}: ${text} is cut off`);
    if (plots.some(plot => overlap(box, plot, 1))) wrong.push(`${name}: ${text} is in a plot`);
    for (const [other, its] of boxes.slice(i + 1)) {
      // Boxes have room above and below their letters.
      if (overlap(box, its, 3)) wrong.push(`${name}: ${text} is over ${other}`);
    }
  });
}

// How many pixels of `rgb` there are.
function count(pixels, rgb) {
  let found = 0;
  for (let i = 0; i < pixels.length; i += 4) {
    if (Math.abs(pixels[i] - rgb[0]) + Math.abs(pixels[i + 1] - rgb[1]) + Math.abs(pixels[i + 2] - rgb[2]) < 40) found++;
  }
  return found;
}

async function draw(svg, name) {
  const [, , width, height] = svg.getAttribute('viewBox').split(' ').map(Number);
  const copy = svg.cloneNode(true);
  copy.setAttribute('width', width);
  copy.setAttribute('height', height);
  const image = new Image();
  image.src = 'data:image/svg+xml;charset=utf-8,' + encodeURIComponent(new XMLSerializer().serializeToString(copy));
  await image.decode();
  const canvas = document.createElement('canvas');
  canvas.width = width;
  canvas.height = height;
  const context = canvas.getContext('2d', { willReadFrequently: true });
  context.fillStyle = '#fff';
  context.fillRect(0, 0, width, height);
  context.drawImage(image, 0, 0);
  const pixels = context.getImageData(0, 0, width, height).data;
  const colours = new Set();
  for (const it of svg.querySelectorAll('polyline, polygon')) {
    const colour = it.getAttribute('stroke') || it.getAttribute('fill');
    if (it.getAttribute('opacity') === '1') colours.add(colour);
  }
  for (const colour of colours) {
    const rgb = [1, 3, 5].map(at => parseInt(colour.slice(at, at + 2), 16));
    curves++;
    if (count(pixels, rgb) < 20) wrong.push(`${name}: nothing is to be seen of ${colour}`);
  }
}

(async () => {
  const room = document.documentElement.scrollWidth - document.documentElement.clientWidth;
  if (room > 0) wrong.push(`the page is ${room} too wide`);
  const figures = [...document.querySelectorAll('figure')];
  for (const figure of figures) {
    const svg = figure.querySelector('svg');
    const name = figure.querySelector('.title').textContent;
    measure(svg, name);
    await draw(svg, name).catch(error => wrong.push(`${name}: ${error}`));
  }
  document.getElementById('measured').textContent = JSON.stringify({ figures: figures.length, curves, wrong });
})();
