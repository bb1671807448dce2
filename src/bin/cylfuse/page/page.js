'use strict';
(() => {
  const content = JSON.parse(document.getElementById('content').textContent);
  const byId = (id) => document.getElementById(id);
  const factor = content.millimetres ?? 1;
  const unit = content.millimetres ? 'mm' : '';
  const titled = (name) => (unit ? `${name} (${unit})` : name);

  /** An element with text, never markup. */
  function element(tag, className, text) {
    const made = document.createElement(tag);
    if (className) made.className = className;
    if (text !== undefined) made.textContent = text;
    return made;
  }

  /** A number with its standard deviation: as many digits as that has a meaning for. */
  function measured(value, deviation) {
    if (value === null || value === undefined) return '';
    const shown = value * factor;
    if (!deviation) return shown.toPrecision(5);
    const own = deviation * factor;
    const digits = Math.min(12, Math.max(0, 1 - Math.floor(Math.log10(own))));
    return `${shown.toFixed(digits)} ± ${own.toFixed(digits)}`;
  }

  // One row a cylinder; a frame without any has one, too.
  const rows = content.frames.flatMap((frame) => {
    const cylinders = frame.cylinders.length ? frame.cylinders : [null];
    return cylinders.map((cylinder) => ({ frame, cylinder }));
  });
  const several = rows.some(({ cylinder }) => cylinder && cylinder.number !== null);
  const judged = content.tolerances.length > 0;
  // What the names of all frames begin with, up to a folder, tells nothing; of a single one the last part stays.
  const folders = content.frames.map((frame) => frame.name.split('/').slice(0, -1));
  let shared = folders[0]?.length ?? 0;
  for (const folder of folders) {
    const differs = folder.findIndex((part, k) => part !== folders[0][k]);
    shared = Math.min(shared, differs < 0 ? folder.length : differs);
  }
  const short = (frame) => frame.name.split('/').slice(shared).join('/');
  const name = ({ frame, cylinder }) =>
    cylinder && cylinder.number !== null ? `${short(frame)} · ${cylinder.number}` : short(frame);
  const words = ({ frame, cylinder }) => {
    if (frame.error) return [frame.error];
    return cylinder ? cylinder.warnings : ['no cylinder found'];
  };
  const order = { fail: 0, undecided: 1, pass: 2 };
  const verdict = (row) => row.cylinder?.judgement?.verdict;

  const columns = [
    { title: 'Frame', className: 'name', key: name, text: name },
    several && { title: 'Score', className: 'number', key: (row) => row.cylinder?.score, text: (row) => row.cylinder?.score?.toFixed(2) ?? '' },
    {
      title: titled('Radius'), className: 'number', key: (row) => row.cylinder?.radius,
      text: ({ cylinder }) => (cylinder ? measured(cylinder.radius, cylinder.radius_deviation) : ''),
    },
    {
      title: titled('Length'), className: 'number', key: (row) => row.cylinder?.length,
      text: ({ cylinder }) => (cylinder ? measured(cylinder.length, cylinder.length_deviation) : ''),
    },
    judged && {
      title: 'Verdict', className: 'verdict', key: (row) => order[verdict(row)], text: (row) => verdict(row) ?? '',
    },
    { title: 'Warnings', className: 'warnings', key: (row) => words(row).length, text: (row) => words(row).join('; ') },
  ].filter(Boolean);

  // The table.
  const body = document.querySelector('tbody');
  const head = document.querySelector('thead').appendChild(element('tr'));
  head.append(element('th'));
  const headers = columns.map((column, index) => {
    const header = head.appendChild(element('th', column.className === 'number' ? 'number' : ''));
    header.appendChild(element('button', '', column.title)).addEventListener('click', () => sort(index));
    byId('order').add(new Option(column.title, index));
    return header;
  });
  for (const row of rows) {
    row.element = element('tr');
    row.element.tabIndex = 0;
    row.element.title = row.frame.name;
    const picture = row.element.appendChild(element('td', 'picture'));
    const shown = row.cylinder?.picture ?? row.frame.picture;
    if (shown) picture.append(image(shown));
    if (shown && row.cylinder?.number) picture.append(numbered(row.cylinder));
    for (const column of columns) {
      const cell = row.element.appendChild(element('td', column.className, column.text(row)));
      if (column.className === 'verdict' && verdict(row)) {
        cell.classList.add(verdict(row));
        // What is well within its limits needs no words beside it.
        if (verdict(row) !== 'pass') cell.append(element('span', 'reason', row.cylinder.judgement.reasons[0]));
      }
      if (column.className === 'warnings' && row.frame.error) cell.classList.add('error');
      if (column.className === 'number') cell.dataset.title = column.title;
    }
    row.element.addEventListener('click', () => choose(row, true));
    row.element.addEventListener('keydown', (event) => { if (event.key === 'Enter') choose(row, true); });
  }

  function image({ jpeg }) {
    const made = new Image();
    made.alt = '';
    made.src = `data:image/jpeg;base64,${jpeg}`;
    return made;
  }

  /** The number of a cylinder in its colour. */
  function numbered({ number, color }) {
    const made = element('span', 'badge', number);
    made.style.borderColor = `rgb(${color})`;
    return made;
  }

  /** A picture with its words, which do not shrink with it. */
  function labelled(picture, alt) {
    const made = element('div', 'labelled');
    const pixels = image(picture);
    pixels.alt = alt;
    made.append(pixels);
    for (const { at: [x, y], text } of picture.labels) {
      const label = element('span', 'label', text);
      label.style.left = `${100 * x}%`;
      label.style.top = `${100 * y}%`;
      made.append(label);
    }
    return made;
  }

  let sorted = { index: -1, descending: false };
  function sort(index) {
    sorted = { index, descending: sorted.index === index && !sorted.descending };
    const { key } = columns[index];
    const sign = sorted.descending ? -1 : 1;
    // What has no value comes last either way.
    const missing = (value) => value === null || value === undefined;
    rows.sort((a, b) => {
      const [x, y] = [key(a), key(b)];
      if (missing(x) || missing(y)) return missing(x) - missing(y);
      return sign * (typeof x === 'string' ? x.localeCompare(y, 'en', { numeric: true }) : x - y);
    });
    headers.forEach((header, k) => {
      if (k === index) header.setAttribute('aria-sort', sorted.descending ? 'descending' : 'ascending');
      else header.removeAttribute('aria-sort');
    });
    byId('order').value = index;
    body.append(...rows.map((row) => row.element));
  }
  byId('order').addEventListener('change', (event) => sort(Number(event.target.value)));

  // The summary.
  const found = rows.filter(({ cylinder }) => cylinder);
  const plural = (count, what) => `${count} ${what}${count === 1 ? '' : 's'}`;
  const parts = [plural(content.frames.length, 'frame'), plural(found.length, 'cylinder')];
  const failed = content.frames.filter((frame) => frame.error).length;
  if (failed) parts.push(`${failed} failed`);
  for (const { quantity, low, high } of content.tolerances) {
    parts.push(`${quantity} from ${+(low * factor).toPrecision(10)} to ${+(high * factor).toPrecision(10)} ${unit}`.trim());
  }
  if (judged) {
    for (const word of ['pass', 'fail', 'undecided']) {
      parts.push(`${found.filter((row) => verdict(row) === word).length} ${word}`);
    }
  }
  byId('summary').textContent = parts.join(', ');
  byId('version').textContent = content.version;
  byId('deviations').hidden = found.length === 0;
  byId('verdicts').hidden = !judged;

  // The histogram.
  const SVG = 'http://www.w3.org/2000/svg';
  function drawn(tag, attributes, text) {
    const made = document.createElementNS(SVG, tag);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== undefined) made.textContent = text;
    return made;
  }
  function histogram() {
    const quantity = byId('quantity').value;
    const values = found.map(({ cylinder }) => cylinder[quantity]).filter((x) => typeof x === 'number').map((x) => x * factor);
    const bars = byId('bars');
    bars.replaceChildren();
    byId('spread').textContent = '';
    if (values.length < 2) {
      byId('spread').textContent = 'fewer than two values';
      return;
    }
    const limits = content.tolerances.filter((tolerance) => tolerance.quantity === quantity)
      .flatMap(({ low, high }) => [low * factor, high * factor]);
    const mean = values.reduce((sum, x) => sum + x, 0) / values.length;
    const deviation = Math.sqrt(values.reduce((sum, x) => sum + (x - mean) ** 2, 0) / (values.length - 1));
    byId('spread').textContent = `mean ${mean.toPrecision(5)}, standard deviation ${deviation.toPrecision(3)} ${unit}`;
    let [low, high] = [Math.min(...values), Math.max(...values)];
    if (!(high > low)) [low, high] = [low - 1e-6 * Math.abs(low) - 1e-12, high + 1e-6 * Math.abs(high) + 1e-12];
    const count = Math.min(40, Math.max(5, Math.ceil(Math.sqrt(values.length) * 1.5)));
    const counts = new Array(count).fill(0);
    for (const x of values) counts[Math.min(count - 1, Math.floor((x - low) / (high - low) * count))] += 1;
    const [from, to] = [Math.min(low, ...limits), Math.max(high, ...limits)];
    // Narrow where the page is, so that the text stays legible.
    const width = Math.max(280, Math.min(900, bars.clientWidth || 600));
    const [height, left, right, bottom, top] = [170, 44, 16, 40, 10];
    const at = (x) => left + (x - from) / (to - from) * (width - left - right);
    const most = Math.max(...counts);
    const up = (n) => height - bottom - n / most * (height - bottom - top);
    const svg = drawn('svg', { viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': `Histogram of the ${quantity}` });
    const text = { 'font-size': 12, fill: '#5b6673' };
    counts.forEach((n, k) => {
      const [x, next] = [low + (high - low) * k / count, low + (high - low) * (k + 1) / count].map(at);
      svg.append(drawn('rect', { x: x + 0.5, y: up(n), width: Math.max(0.5, next - x - 1), height: height - bottom - up(n), fill: '#4a90c2' }));
    });
    svg.append(drawn('line', { x1: left, x2: width - right, y1: height - bottom, y2: height - bottom, stroke: '#5b6673' }));
    for (const n of most > 1 ? [0, most] : [0, 1]) {
      svg.append(drawn('text', { ...text, x: left - 6, y: up(n) + 4, 'text-anchor': 'end' }, n));
    }
    svg.append(drawn('text', { ...text, x: 12, y: (height - bottom + top) / 2, transform: `rotate(-90 12 ${(height - bottom + top) / 2})`, 'text-anchor': 'middle' }, 'count'));
    const ticks = width < 450 ? 3 : 5;
    const digits = Math.min(9, Math.max(0, 1 - Math.floor(Math.log10((to - from) / ticks))));
    for (let k = 0; k < ticks; k += 1) {
      const x = from + (to - from) * k / (ticks - 1);
      const anchor = k === 0 ? 'start' : k === ticks - 1 ? 'end' : 'middle';
      svg.append(drawn('text', { ...text, x: at(x), y: height - bottom + 16, 'text-anchor': anchor }, x.toFixed(digits)));
    }
    svg.append(drawn('text', { ...text, x: (left + width - right) / 2, y: height - 6, 'text-anchor': 'middle' }, titled(quantity)));
    for (const x of limits) {
      svg.append(drawn('line', { x1: at(x), x2: at(x), y1: top, y2: height - bottom, stroke: '#b3261e', 'stroke-dasharray': '5 4', 'stroke-width': 1.5 }));
    }
    bars.append(svg);
  }
  byId('quantity').addEventListener('change', histogram);

  // Points and cylinders in 3D.
  const canvas = document.querySelector('#view canvas');
  let world = null;
  function start3d() {
    // Asked first: the library would complain in the console where there is no WebGL.
    const context = canvas.getContext('webgl2', { antialias: true, preserveDrawingBuffer: true });
    if (!context) {
      byId('hint').textContent = 'This browser shows no 3D (WebGL 2).';
      return null;
    }
    const renderer = new THREE.WebGLRenderer({ canvas, context, antialias: true });
    renderer.setClearColor(0xf3f6f8);
    const camera = new THREE.PerspectiveCamera(40, 4 / 3, 0.001, 1000);
    const controls = new THREE.OrbitControls(camera, canvas);
    const made = { renderer, camera, controls, scene: new THREE.Scene() };
    controls.addEventListener('change', () => render(made));
    return made;
  }
  function render({ renderer, camera, scene }) {
    const { clientWidth: width, clientHeight: height } = canvas;
    if (!width || !height) return;
    renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    renderer.render(scene, camera);
  }

  function points(frame) {
    const bytes = Uint8Array.from(atob(frame.points), (letter) => letter.charCodeAt(0));
    const view = new DataView(bytes.buffer);
    return Float32Array.from({ length: bytes.length / 4 }, (_, k) => view.getFloat32(4 * k, true));
  }

  /** The ends of what is drawn: those found, else as far as the points of the surface go. */
  function endsOf(cylinder, cloud, origin) {
    const place3 = (numbers) => new THREE.Vector3(...numbers.map((x, k) => x - origin[k]));
    if (cylinder.ends) return cylinder.ends.map(place3);
    const [point, direction] = [place3(cylinder.point), new THREE.Vector3(...cylinder.direction)];
    let [low, high] = [Infinity, -Infinity];
    const place = new THREE.Vector3();
    for (let k = 0; k < cloud.length; k += 3) {
      place.fromArray(cloud, k).sub(point);
      const along = place.dot(direction);
      const across = Math.sqrt(Math.max(0, place.lengthSq() - along * along));
      if (Math.abs(across - cylinder.radius) < 0.2 * cylinder.radius) [low, high] = [Math.min(low, along), Math.max(high, along)];
    }
    if (!(high > low)) [low, high] = [-cylinder.radius, cylinder.radius];
    return [low, high].map((along) => point.clone().addScaledVector(direction, along));
  }

  function surface(cylinder, [start, end], color) {
    const SIDES = 64;
    const axis = end.clone().sub(start).normalize();
    const helper = Math.abs(axis.x) < 0.7 ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 1, 0);
    const u = helper.cross(axis).normalize();
    const v = axis.clone().cross(u);
    const rim = (middle, k) => middle.clone()
      .addScaledVector(u, cylinder.radius * Math.cos(2 * Math.PI * k / SIDES))
      .addScaledVector(v, cylinder.radius * Math.sin(2 * Math.PI * k / SIDES));
    const [triangles, lines] = [[], []];
    for (let k = 0; k < SIDES; k += 1) {
      const [a, b, c, d] = [rim(start, k), rim(start, k + 1), rim(end, k), rim(end, k + 1)];
      triangles.push(a, b, c, c, b, d);
      lines.push(a, b, c, d);
      if (k % 8 === 0) lines.push(a, c);
    }
    const geometry = (list) => new THREE.BufferGeometry().setFromPoints(list);
    const skin = new THREE.MeshBasicMaterial({ color, transparent: true, opacity: 0.28, side: THREE.DoubleSide, depthWrite: false });
    return [
      new THREE.Mesh(geometry(triangles), skin),
      new THREE.LineSegments(geometry(lines), new THREE.LineBasicMaterial({ color })),
      new THREE.LineSegments(geometry([start, end]), new THREE.LineBasicMaterial({ color })),
    ];
  }

  function show({ frame, cylinder }) {
    world ??= start3d();
    if (!world) return;
    world.scene.traverse((thing) => { thing.geometry?.dispose(); thing.material?.dispose(); });
    world.scene = new THREE.Scene();
    const cloud = points(frame);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(cloud, 3));
    world.scene.add(new THREE.Points(geometry, new THREE.PointsMaterial({ color: 0x33414f, size: 2.5, sizeAttenuation: false })));
    for (const each of frame.cylinders) {
      const color = new THREE.Color(`rgb(${each.color})`);
      world.scene.add(...surface(each, endsOf(each, cloud, frame.origin), color));
    }
    const target = new THREE.Vector3();
    let size = 1;
    if (cylinder) {
      const [start, end] = endsOf(cylinder, cloud, frame.origin);
      target.addVectors(start, end).multiplyScalar(0.5);
      size = end.distanceTo(start) + 2 * cylinder.radius;
    } else if (cloud.length) {
      geometry.computeBoundingSphere();
      target.copy(geometry.boundingSphere.center);
      size = 2 * geometry.boundingSphere.radius;
    }
    // As the depth camera sees it, from a little to the side and above: y is down.
    const seen = new THREE.Vector3(...frame.origin).add(target);
    const away = seen.lengthSq() > 0 ? seen.normalize() : new THREE.Vector3(0, 0, 1);
    const side = new THREE.Vector3(0, -1, 0).cross(away).normalize();
    const from = away.multiplyScalar(-1).addScaledVector(side, 0.55).add(new THREE.Vector3(0, -0.45, 0)).normalize();
    world.camera.up.set(0, -1, 0);
    world.camera.near = size / 100;
    world.camera.far = 100 * size + 10 * target.length();
    world.camera.position.copy(target).addScaledVector(from, (several ? 3 : 1.7) * size);
    world.controls.target.copy(target);
    world.controls.update();
    render(world);
  }

  let chosen = null;
  function choose(row, byHand) {
    chosen?.element.classList.remove('chosen');
    chosen = row;
    row.element.classList.add('chosen');
    const detail = byId('detail');
    detail.hidden = false;
    detail.querySelector('h2').textContent = name(row);
    const { frame, cylinder } = row;
    byId('view').hidden = !frame.points;
    const pictures = [];
    if (cylinder?.picture) pictures.push(labelled(cylinder.picture, 'The cylinder over the image'));
    if (frame.picture) pictures.push(labelled(frame.picture, 'All cylinders of the frame'));
    byId('pictures').replaceChildren(...pictures);
    const list = detail.querySelector('dl');
    list.replaceChildren();
    const say = (term, text) => {
      if (text) list.append(element('dt', '', term), element('dd', '', text));
    };
    if (cylinder) {
      say(titled('Radius'), measured(cylinder.radius, cylinder.radius_deviation));
      say(titled('Length'), measured(cylinder.length, cylinder.length_deviation));
      say('Ends', cylinder.end_states);
      say('Axis', cylinder.direction.map((x) => x.toFixed(4)).join(', '));
      say('Verdict', cylinder.judgement && [cylinder.judgement.verdict, ...cylinder.judgement.reasons].join('; '));
    }
    say('Warnings', words(row).join('; '));
    if (frame.points) show(row);
    if (byHand && window.matchMedia('(max-width: 900px)').matches) detail.scrollIntoView({ behavior: 'smooth' });
  }

  sort(0);
  byId('histogram').hidden = found.length < 2;
  histogram();
  if (rows.length) choose(rows[0], false);
  let waiting = 0;
  window.addEventListener('resize', () => {
    cancelAnimationFrame(waiting);
    waiting = requestAnimationFrame(() => {
      histogram();
      if (world) render(world);
    });
  });
})();
