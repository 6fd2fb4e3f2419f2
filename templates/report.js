// What the page of a report does beside being read: depths to go through, claims to filter, pictures to look at
// closely, sections that fold on a phone. The page says all that it says without this. Words stand in the page
// (explore.html, report.html.mustache), numbers in its data; nothing is loaded.
(() => {
'use strict';
const byId = (id) => document.getElementById(id);
const all = (what, where = document) => [...where.querySelectorAll(what)];
const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

// Sections fold on a phone; a link into one opens it, and paper has all of them.
const folds = all('details.fold'), phone = matchMedia('(max-width: 39.99rem)');
if (phone.matches) folds.forEach((one) => { one.open = false; });
phone.addEventListener('change', () => { if (!phone.matches) folds.forEach((one) => { one.open = true; }); });
const reveal = () => {
  const target = location.hash.length > 1 && byId(decodeURIComponent(location.hash.slice(1)));
  const closed = [];
  for (let one = target; one; one = one.parentElement) if (one.localName === 'details' && !one.open) closed.push(one);
  closed.forEach((one) => { one.open = true; });
  if (closed.length) target.scrollIntoView();
};
addEventListener('hashchange', reveal);
document.addEventListener('click', (event) => { if (event.target.closest('a[href^="#"]')) setTimeout(reveal); });
reveal();
let folded = [];
addEventListener('beforeprint', () => { folded = folds.filter((one) => !one.open); folded.forEach((one) => { one.open = true; }); });
addEventListener('afterprint', () => folded.forEach((one) => { one.open = false; }));

// Claims: those of one verdict, in another order.
function claims(table, tools) {
  const rows = all('tbody tr:not(.group)', table).map((row, index) => {
    const pull = row.querySelector('.pull-number');
    return {row, index, look: row.querySelector('.verdict').classList[1], name: row.querySelector('.statement').textContent,
      pull: pull ? Math.abs(parseFloat(pull.textContent.replace('−', '-'))) : -1};
  });
  const buttons = all('button', tools).filter((button) => {
    const count = rows.filter((one) => !button.dataset.look || one.look === button.dataset.look).length;
    button.append(` ${count}`);
    if (!count) button.remove();
    return count;
  });
  const show = (look) => {
    buttons.forEach((button) => button.setAttribute('aria-pressed', button.dataset.look === look));
    rows.forEach((one) => { one.row.hidden = look !== '' && one.look !== look; });
    all('tbody', table).forEach((body) => {
      body.hidden = all('tr:not(.group)', body).every((row) => row.hidden);
    });
  };
  buttons.forEach((button) => button.addEventListener('click', () => show(button.dataset.look)));
  const orders = {look: (a, b) => a.index - b.index, pull: (a, b) => b.pull - a.pull, name: (a, b) => a.name.localeCompare(b.name)};
  const order = tools.querySelector('select');
  order.addEventListener('change', () => [...rows].sort(orders[order.value]).forEach((one) => one.row.parentNode.append(one.row)));
  if (phone.matches && rows.some((one) => one.look === 'no')) show('no');
  tools.hidden = false;
}
if (byId('claim-tools')) claims(document.querySelector('table.claims'), byId('claim-tools'));

// A picture over the whole window: drag or pinch, wheel, + and −, arrow keys; Escape closes.
function closeLook(dialog) {
  const view = dialog.querySelector('.view'), image = view.appendChild(document.createElement('img')), fingers = new Map();
  let scale = 1, smallest = 1, x = 0, y = 0;
  const place = () => {
    const [w, h] = [image.naturalWidth * scale, image.naturalHeight * scale], [W, H] = [view.clientWidth, view.clientHeight];
    x = w < W ? (W - w) / 2 : clamp(x, W - w, 0);
    y = h < H ? (H - h) / 2 : clamp(y, H - h, 0);
    image.style.transform = `translate(${x}px,${y}px) scale(${scale})`;
  };
  const zoom = (factor, atX = view.clientWidth / 2, atY = view.clientHeight / 2) => {
    const now = clamp(scale * factor, smallest, 20 * smallest);
    x = atX - (atX - x) * now / scale;
    y = atY - (atY - y) * now / scale;
    scale = now;
    place();
  };
  const open = (picture, fractionX, fractionY) => {
    image.className = picture.className;
    image.alt = picture.alt;
    image.src = picture.currentSrc || picture.src;
    dialog.showModal();
    image.decode().catch(() => {}).then(() => {
      const [across, down] = [view.clientWidth / image.naturalWidth, view.clientHeight / image.naturalHeight];
      smallest = Math.min(across, down);
      scale = clamp(Math.max(across, down), 1.5 * smallest, 4 * smallest);
      x = view.clientWidth / 2 - fractionX * image.naturalWidth * scale;
      y = view.clientHeight / 2 - fractionY * image.naturalHeight * scale;
      place();
    });
  };
  all('.picture a').forEach((link) => link.addEventListener('click', (event) => {
    if (event.ctrlKey || event.metaKey || event.shiftKey || event.altKey) return;
    event.preventDefault();
    const picture = link.querySelector('img'), box = picture.getBoundingClientRect();
    const byKey = event.detail === 0;  // Enter has no place
    open(picture, byKey ? 0.5 : (event.clientX - box.x) / box.width, byKey ? 0.5 : (event.clientY - box.y) / box.height);
  }));
  const middle = (points) => points.reduce(([a, b], one) => [a + one.clientX / points.length, b + one.clientY / points.length], [0, 0]);
  const spread = ([a, b]) => b ? Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY) : 1;
  view.addEventListener('pointerdown', (event) => {
    fingers.set(event.pointerId, event);
    try { view.setPointerCapture(event.pointerId); } catch { /* of a pointer that is gone already */ }
    event.preventDefault();
  });
  view.addEventListener('pointermove', (event) => {
    if (!fingers.has(event.pointerId)) return;
    const before = [...fingers.values()];
    fingers.set(event.pointerId, event);
    const after = [...fingers.values()], [fromX, fromY] = middle(before), [toX, toY] = middle(after);
    x += toX - fromX;
    y += toY - fromY;
    zoom(spread(after) / Math.max(spread(before), 1), toX, toY);
  });
  for (const end of ['pointerup', 'pointercancel']) view.addEventListener(end, (event) => fingers.delete(event.pointerId));
  view.addEventListener('wheel', (event) => {
    event.preventDefault();
    zoom(Math.exp(-event.deltaY / 300), event.clientX, event.clientY);
  }, {passive: false});
  view.addEventListener('dblclick', (event) => zoom(2, event.clientX, event.clientY));
  const step = {ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]};
  dialog.addEventListener('keydown', (event) => {
    if (event.key === '+' || event.key === '-') zoom(event.key === '+' ? 1.5 : 1 / 1.5);
    if (!step[event.key]) return;
    event.preventDefault();
    x += 60 * step[event.key][0];
    y += 60 * step[event.key][1];
    place();
  });
  dialog.addEventListener('close', () => { fingers.clear(); image.removeAttribute('src'); });
  dialog.querySelector('[data-do=in]').addEventListener('click', () => zoom(1.5));
  dialog.querySelector('[data-do=out]').addEventListener('click', () => zoom(1 / 1.5));
  dialog.querySelector('[data-do=close]').addEventListener('click', () => dialog.close());
  addEventListener('resize', () => { if (dialog.open) place(); });
}
if (byId('close-look') && byId('close-look').showModal) closeLook(byId('close-look'));

// The response depth by depth.
function explore(box, results) {
  const svg = byId('explore-plot'), depthInput = byId('explore-depth'), note = byId('explore-note');
  const words = svg.dataset, told = note.innerHTML;
  const values = Object.fromEntries(all('[data-value]', box).map((one) => [one.dataset.value, one]));

  // "53.374(61)" as value and error.
  const numberOf = (text) => {
    if (text === null) return null;
    const [, value, error, power] = /^([−\d.]+)(?:\(([\d.]+)\))?(?: × 10(.+))?$/.exec(text) || [text, 'NaN'];
    const decimals = (value.split('.')[1] || '').length, unit = power ? 10 ** [...power].map((c) => '-0123456789'['⁻⁰¹²³⁴⁵⁶⁷⁸⁹'.indexOf(c)]).join('') : 1;
    return {value: Number(value.replace('−', '-')) * unit, error: unit * (!error ? 0 : error.includes('.') ? Number(error) : error / 10 ** decimals)};
  };
  // Abramowitz and Stegun 7.1.26: within 1.5e-7.
  const erf = (x) => {
    const t = 1 / (1 + 0.3275911 * Math.abs(x));
    const tail = t * (0.254829592 + t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027 + t * 1.061405429)))) * Math.exp(-x * x);
    return Math.sign(x) * (1 - tail);
  };
  // Two mirror Gaussians of area ½, integrated over the width of a bead.
  const fitAt = (one, x) => [one.x_p, -one.x_p].reduce((sum, peak) =>
    sum + (erf((x + 0.5 - peak) / one.W / Math.SQRT2) - erf((x - 0.5 - peak) / one.W / Math.SQRT2)) / 4, 0);

  for (const result of results) {
    result.depths = result.depths.map((depth) => {
      const peak = numberOf(depth.x_p), width = numberOf(depth.W);
      const one = {text: depth, z: Number(depth.z), peak, width, x_p: peak && peak.value, W: width && width.value};
      one.fitted = Boolean(peak && width && width.value > 0);
      one.inside = depth.layer >= result.window[0] && depth.layer <= result.window[1];
      one.beads = depth.P.map((P, i) => {
        const bead = {x: depth.x[0] + i * depth.x[1], P: P * result.unit, error: depth.error[i] * result.unit};
        bead.fit = one.fitted ? fitAt(one, bead.x) : null;
        bead.residual = one.fitted && bead.error > 0 ? (bead.P - bead.fit) / bead.error : null;
        return bead;
      });
      one.highest = Math.max(...one.beads.map((bead) => bead.P + bead.error));
      one.lowest = Math.min(0, ...one.beads.map((bead) => bead.P - bead.error));
      return one;
    });
    const last = result.depths[result.depths.length - 1];
    result.reach = Math.max(...result.depths.map((one) => one.fitted ? one.x_p + 5 * one.W + 3 : 0));
    if (!(result.reach > 0)) result.reach = last.beads[last.beads.length - 1].x;
    result.half = Math.max(8, ...result.depths.map((one) => one.fitted ? Math.ceil(5 * one.W) : 0));
    result.deepest = last.z;
    result.atSlope = (z) => ({
      x_p: result.position && result.position[0] + result.position[1] * z,
      W: result.square && Math.sqrt(Math.max(0, result.square[0] + result.square[1] * z))});
  }

  const create = (name, attributes, text) => {
    const one = document.createElementNS(svg.namespaceURI, name);
    for (const key in attributes) one.setAttribute(key, attributes[key]);
    if (text !== undefined) one.textContent = text;
    return one;
  };
  const draw = (name, attributes, text) => svg.appendChild(create(name, attributes, text));
  const marks = (low, high, most) => {
    const raw = (high - low) / most, ten = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((n) => n * ten).find((n) => n >= raw);
    const found = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) found.push(k * step);
    return {found, decimals: Math.max(0, -Math.floor(Math.log10(step) + 1e-9))};
  };
  const label = (value, decimals) => value === 0 ? '0' : value.toFixed(decimals).replace(/^-(?=.*[1-9])/, '−').replace(/^-/, '');

  // A panel with its frame; what it returns turns data into places.
  const panel = (area, across, up, title, below) => {
    const X = (value) => area.x + (value - across[0]) / (across[1] - across[0]) * area.width;
    const Y = (value) => area.y + area.height - (value - up[0]) / (up[1] - up[0]) * area.height;
    const xs = marks(...across, Math.max(3, area.width / 80)), ys = marks(...up, Math.max(5, area.height / 40));
    for (const value of xs.found) {
      draw('line', {class: 'grid', x1: X(value), x2: X(value), y1: area.y, y2: area.y + area.height});
      if (below) draw('text', {x: X(value), y: area.y + area.height + 15, 'text-anchor': 'middle'}, label(value, xs.decimals));
    }
    for (const value of ys.found) {
      draw('line', {class: 'grid', x1: area.x, x2: area.x + area.width, y1: Y(value), y2: Y(value)});
      draw('text', {x: area.x - 5, y: Y(value) + 4, 'text-anchor': 'end'}, label(value, ys.decimals));
    }
    draw('text', {class: 'title', x: area.x, y: area.y - 6}, title);
    if (below) draw('text', {class: 'title', x: area.x + area.width, y: area.y + area.height + 31, 'text-anchor': 'end'}, below);
    return {area, X, Y, inside: (x, y) => x >= area.x - 8 && x <= area.x + area.width + 8 && y >= area.y && y <= area.y + area.height};
  };
  const line = (points, name) => {
    if (points.length > 1) draw('path', {class: name, d: 'M' + points.map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`).join('L')});
  };
  const dots = (points, name) => draw('path', {class: name, d: points.map(([x, y]) => `M${x.toFixed(1)} ${y.toFixed(1)}h0`).join('')});
  const bars = (points) => draw('path', {class: 'bar', d: points.map(([x, y, to]) => `M${x.toFixed(1)} ${y.toFixed(1)}V${to.toFixed(1)}`).join('')});
  const range = (from, to, step) => Array.from({length: Math.floor((to - from) / step) + 1}, (_, i) => from + i * step);

  // First the middle one of those with enough depths fitted.
  const fitted = (one) => one.depths.filter((depth) => depth.fitted).length;
  const best = results.filter((one) => fitted(one) >= 0.7 * Math.max(...results.map(fitted)));
  let result = best[Math.floor((best.length - 1) / 2)], at = 0, panels = {};

  function plot() {
    const W = Math.max(280, svg.clientWidth), wide = W >= 620, left = 44, gap = 34;
    const one = result.depths[at];
    const half = wide ? (W - left - 52) / 2 : W - left - 8;
    const tall = wide ? 170 : 130, close = wide ? 170 : 150, low = 80;
    const second = 22 + tall + 62, third = second + close + 24;
    const growth = wide ? [{x: left + half + 52, y: second, width: half - 8, height: 125}, {x: left + half + 52, y: second + 149, width: half - 8, height: 125}]
      : [{x: left, y: third + low + 60, width: W / 2 - left - 4, height: 110}, {x: W / 2 + 40, y: third + low + 60, width: W / 2 - 48, height: 110}];
    const H = Math.max(third + low, growth[1].y + growth[1].height) + 40;
    svg.replaceChildren();
    svg.setAttribute('viewBox', `0 0 ${W} ${H}`);
    svg.style.height = `${H}px`;

    const most = 1.06 * Math.max(...result.depths.map((depth) => depth.highest));
    const least = Math.min(...result.depths.map((depth) => depth.lowest)) - 0.02 * most;
    const whole = panel({x: left, y: 22, width: W - left - 8, height: tall}, [-result.reach, result.reach], [least, most], words.response, words.place);
    const seen = one.beads.filter((bead) => bead.x <= result.reach);
    const both = seen.flatMap((bead) => bead.x > 0 ? [bead, {...bead, x: -bead.x}] : [bead]).sort((a, b) => a.x - b.x);
    bars(both.map((bead) => [whole.X(bead.x), whole.Y(bead.P - bead.error), whole.Y(bead.P + bead.error)]));
    dots(both.map((bead) => [whole.X(bead.x), whole.Y(bead.P)]), 'dot small');
    if (one.fitted) line(range(-result.reach, result.reach, 2 * result.reach / W).map((x) => [whole.X(x), whole.Y(fitAt(one, x))]), 'fit');

    const centre = one.fitted ? one.x_p : result.atSlope(one.z).x_p || result.reach / 2;
    const across = [centre - result.half, centre + result.half];
    const near = both.filter((bead) => bead.x >= across[0] && bead.x <= across[1]);
    const peak = 1.08 * Math.max(1e-9, ...near.map((bead) => Math.max(bead.P + bead.error, bead.fit || 0)));
    const below = Math.min(-0.05 * peak, ...near.map((bead) => bead.P - bead.error));
    const top = panel({x: left, y: second, width: half, height: close}, across, [below, peak], words.response);
    bars(near.map((bead) => [top.X(bead.x), top.Y(bead.P - bead.error), top.Y(bead.P + bead.error)]));
    if (one.fitted) line(range(...across, result.half / half).map((x) => [top.X(x), top.Y(fitAt(one, x))]), 'fit');
    dots(near.map((bead) => [top.X(bead.x), top.Y(bead.P)]), 'dot');

    const off = near.filter((bead) => bead.residual !== null);
    const reach = Math.max(3.5, ...off.map((bead) => Math.abs(bead.residual) + 1.2));
    const bottom = panel({x: left, y: third, width: half, height: low}, across, [-reach, reach], words.residual, words.place);
    if (off.length) draw('line', {class: 'fit', x1: left, x2: left + half, y1: bottom.Y(0), y2: bottom.Y(0)});
    bars(off.map((bead) => [bottom.X(bead.x), bottom.Y(bead.residual - 1), bottom.Y(bead.residual + 1)]));
    dots(off.map((bead) => [bottom.X(bead.x), bottom.Y(bead.residual)]), 'dot');

    const deepest = 1.03 * result.deepest;
    const grown = ['x_p', 'W'].map((name, k) => {
      const number = name === 'W' ? 'width' : 'peak', known = result.depths.filter((depth) => depth[number]);
      const highest = Math.max(1e-9, ...known.map((depth) => depth[number].value + depth[number].error));
      const one = panel(growth[k], [0, deepest], [0, 1.05 * highest], k ? words.width : words.peak, wide && !k ? '' : words.depth);
      const inside = result.depths.filter((depth) => depth.inside);
      if (inside.length > 1 && result.atSlope(1)[name] !== null) {
        line(range(inside[0].z, inside[inside.length - 1].z, 1).map((z) => [one.X(z), one.Y(result.atSlope(z)[name])]), 'fit');
      }
      bars(known.map((depth) => [one.X(depth.z), one.Y(depth[number].value - depth[number].error), one.Y(depth[number].value + depth[number].error)]));
      for (const depth of known) {
        draw('circle', {class: depth.inside ? 'point' : 'point open', cx: one.X(depth.z), cy: one.Y(depth[number].value), r: 2.4});
      }
      const now = result.depths[at];
      draw('line', {class: 'now', x1: one.X(now.z), x2: one.X(now.z), y1: growth[k].y, y2: growth[k].y + growth[k].height});
      if (now[number]) draw('circle', {class: 'now', cx: one.X(now.z), cy: one.Y(now[number].value), r: 6});
      return one;
    });
    panels = {response: [whole, top, bottom], grown, deepest, both, one};
  }

  function tell() {
    const one = result.depths[at], text = one.text, dof = text.dof;
    const set = (name, words) => { values[name].textContent = words === null ? '–' : words; };
    set('z', text.z);
    set('layer', text.layer);
    set('x_p', text.x_p);
    set('W', text.W);
    set('chi2', text.chi2);
    set('expected', text.chi2 === null ? '' : values.expected.dataset.words.replace('{}', Math.sqrt(2 / dof).toFixed(2)));
    set('c', result.c);
    set('D', result.D);
    depthInput.max = result.depths.length - 1;
    depthInput.value = at;
    depthInput.setAttribute('aria-valuetext', `z = ${text.z}, x_p = ${text.x_p || '–'}, W = ${text.W || '–'}`);
    if (text.reason) note.textContent = note.dataset.unfitted.replace('{}', text.reason);
    else note.innerHTML = told;
  }

  const go = (to) => {
    at = clamp(to, 0, result.depths.length - 1);
    tell();
    plot();
  };
  const nearest = (z) => result.depths.reduce((best, one, i, every) => Math.abs(one.z - z) < Math.abs(every[best].z - z) ? i : best, 0);
  const choose = (other) => {
    const z = result.depths[at].z;
    result = other;
    go(nearest(z));
  };

  byId('explore-scanned').append(...results.map((one) => {
    const chip = document.createElement('label'), input = document.createElement('input');
    Object.assign(input, {type: 'radio', name: 'explore-scanned', value: one.scanned, checked: one === result});
    input.addEventListener('change', () => choose(one));
    chip.append(input, document.createElement('span'));
    chip.lastChild.textContent = one.scanned;
    return chip;
  }));
  depthInput.addEventListener('input', () => go(Number(depthInput.value)));
  // The same keys wherever the focus is, but for the choice of friction, which has its own arrows.
  const steps = {ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -10, PageUp: 10, Home: -Infinity, End: Infinity};
  box.addEventListener('keydown', (event) => {
    if (!(event.key in steps) || event.target.type === 'radio' || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    go(at + steps[event.key]);
  });
  const touched = (event) => {
    const frame = svg.getBoundingClientRect(), x = event.clientX - frame.x, y = event.clientY - frame.y;
    const grown = panels.grown.find((one) => one.inside(x, y));
    if (grown && (event.type === 'pointerdown' || event.buttons > 0)) {
      go(nearest((x - grown.area.x) / grown.area.width * panels.deepest));
    }
    const shown = panels.response.find((one) => one.inside(x, y));
    if (!shown) return;
    const bead = panels.both.reduce((best, one) => Math.abs(shown.X(one.x) - x) < Math.abs(shown.X(best.x) - x) ? one : best);
    if (bead.residual === null) return;
    const digits = Math.max(0, 1 - Math.floor(Math.log10(bead.error)));
    const numbers = {x: label(bead.x, bead.x % 1 ? 1 : 0), P: label(bead.P, digits), error: label(bead.error, digits), fit: label(bead.fit, digits), residual: label(bead.residual, 1)};
    note.textContent = note.dataset.bead.replace(/\{(\w+)\}/g, (_, name) => numbers[name]);
  };
  for (const name of ['pointerdown', 'pointermove']) svg.addEventListener(name, touched);
  svg.addEventListener('pointerleave', tell);
  box.hidden = false;
  let seen = 0;
  new ResizeObserver(() => { if (svg.clientWidth !== seen) { seen = svg.clientWidth; plot(); } }).observe(svg);
  go(Math.floor(0.6 * result.depths.length));
}
if (byId('explore-data')) explore(byId('explore'), JSON.parse(byId('explore-data').textContent));
})();
