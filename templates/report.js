// What the page of a report does beside being read: depths to go through, claims to filter, pictures to look at
// closely, sections that fold on a phone. The page says all that it says without this. Words stand in the page
// (explore.html, report.html.mustache), numbers in its data; nothing is loaded.
(() => {
'use strict';
const byId = (id) => document.getElementById(id);
const all = (what, where = document) => [...where.querySelectorAll(what)];
const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

// Sections are folded on a phone; a link into one opens it, and paper has all of them.
const folds = all('details.fold'), phone = matchMedia('(max-width: 39.99rem)');
const unfold = () => { if (!phone.matches) folds.forEach((one) => { one.open = true; }); };
phone.addEventListener('change', unfold);
unfold();
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
  const rows = all('tbody tr', table).map((row, index) => {
    const pull = row.querySelector('.pull-number');
    return {row, index, look: row.querySelector('.verdict').classList[1], name: row.querySelector('.statement').textContent,
      pull: pull ? Math.abs(parseFloat(pull.textContent.replace('−', '-'))) : -1};
  });
  const buttons = all('button', tools).filter((button) => {
    const count = rows.filter((one) => !button.dataset.look || one.look === button.dataset.look).length;
    if (!count) button.remove();
    return count;
  });
  const show = (look) => {
    buttons.forEach((button) => button.setAttribute('aria-pressed', button.dataset.look === look));
    rows.forEach((one) => { one.row.hidden = look !== '' && one.look !== look; });
  };
  buttons.forEach((button) => button.addEventListener('click', () => show(button.dataset.look)));
  const orders = {look: (a, b) => a.index - b.index, pull: (a, b) => b.pull - a.pull, name: (a, b) => a.name.localeCompare(b.name)};
  const order = tools.querySelector('select');
  order.addEventListener('change', () => [...rows].sort(orders[order.value]).forEach((one) => one.row.parentNode.append(one.row)));
  if (phone.matches && rows.some((one) => one.look === 'no')) show('no');
  tools.hidden = false;
}
if (byId('claim-tools')) claims(document.querySelector('table.claims'), byId('claim-tools'));

// A number with its standard error in the last digits, as the page has it: 0.0773(33).
const sign = (text) => text.replace(/^-/, '−');
const measured = (value, error) => {
  if (!(error > 0)) return sign(String(Number(value.toPrecision(6))));
  const two = Number(error.toPrecision(2)), largest = Math.max(Math.abs(value), two);
  if (largest < 1e-3 || largest >= 1e6) {
    const power = Math.floor(Math.log10(largest));
    return `${measured(value / 10 ** power, error / 10 ** power)} × 10${[...String(power)].map((c) => '⁻⁰¹²³⁴⁵⁶⁷⁸⁹'['-0123456789'.indexOf(c)]).join('')}`;
  }
  const decimals = Math.max(0, 1 - Math.floor(Math.log10(two)));
  return `${sign(value.toFixed(decimals))}(${two < 1 ? Math.round(two * 10 ** decimals) : two.toFixed(decimals)})`;
};

// Points of plots tell their numbers. A plot names the data of each curve and the ends of its axes (figure.gp.mustache),
// so that its marks are the rows that lie inside, one after the other.
const tip = byId('point-tip'), ring = byId('point-ring');
const points = (() => {
  const decoded = (link) => decodeURIComponent(link.slice(link.indexOf(',') + 1));
  const words = {mu: 'μ', chi2_per_dof: 'χ²/dof', z_from: 'from z', z_to: 'to z'};
  const told = (name) => words[name] || name.replaceAll('x_p', 'xₚ').replaceAll('c0', 'c₀').replaceAll('^2', '²').replaceAll('*', ' ');
  const known = new Map();
  const read = (image) => {
    const article = image.closest('article'), source = image.currentSrc || image.src, found = {width: 1, height: 1, points: []};
    if (!source.startsWith('data:image/svg')) return found;
    const svg = new DOMParser().parseFromString(decoded(source), 'image/svg+xml');
    [found.width, found.height] = svg.documentElement.getAttribute('viewBox').split(' ').slice(2).map(Number);
    const redraw = article.querySelector('.redraw code'), files = {};
    for (const group of svg.querySelectorAll('g[id^=gnuplot_plot_]')) {
      const [data, ...axes] = group.querySelector('title').textContent.split(' | '), [word, file, columns, style, ...ends] = data.split(' ');
      const link = word === 'data' && article.querySelector(`a[download="${file}"][href^=data]`);
      if (!link) continue;
      files[file] = files[file] || decoded(link.getAttribute('href')).trim().split('\n').map((line) => line.split(','));
      const names = files[file][0], used = columns.split(':').map((one) => Number(one) - 1), [low, high, below, above] = ends.map(Number);
      const rows = files[file].map((cells, i) => ({line: i + 1, of: cells.map(Number)})).filter(({of}) =>
        of[used[0]] >= low && of[used[0]] <= high && of[used[1]] >= below && of[used[1]] <= above);
      const marks = all('use:not([color="#FFFFFF"])', group).map((one) => /translate\(([-\d.]+),([-\d.]+)/.exec(one.getAttribute('transform')).slice(1).map(Number));
      if (marks.length !== rows.length) continue;
      // The columns of the bars, of x and of y; of two ends the upper one counts, since axes cut the lower one.
      const bars = {yerrorbars3: [0, [2]], yerrorlines3: [0, [2]], yerrorbars4: [0, [2, 3]], xyerrorbars4: [[2], [3]], xyerrorbars6: [[2, 3], [4, 5]]}[style + used.length] || [0, 0];
      const bar = (of, k) => !bars[k] ? 0 : bars[k].length === 1 ? of[used[bars[k][0]]] : of[used[bars[k][1]]] - of[used[k]];
      rows.forEach(({line, of}, i) => {
        const own = names.map((name, k) => k).filter((k) => /^(mu|z|z_from|z_to|layer|chi2_per_dof|samples)$/.test(names[k]) && ![of[used[0]], of[used[1]], 0].includes(of[k]) && Number.isFinite(of[k]));
        found.points.push({x: marks[i][0], y: marks[i][1], where: `figures/${file}:${line}`, command: redraw ? redraw.textContent : '', series: axes[2] || '',
          text: [0, 1].map((k) => `${axes[k] && axes[k].split('  ')[0].replace(/ \(.*/, '') || told(names[used[k]])} = ${measured(of[used[k]], bar(of, k))}`)
            .concat(own.map((k) => `${told(names[k])} = ${measured(of[k])}`)).join(', ')});
      });
    }
    return found;
  };
  const of = (image, picture = image) => {
    const source = picture.currentSrc || picture.src;
    if (!known.has(source)) known.set(source, read(picture));
    return known.get(source);
  };
  const place = (image, plot, point) => {
    const box = image.getBoundingClientRect(), style = getComputedStyle(image), edge = parseFloat(style.paddingLeft) + parseFloat(style.borderLeftWidth);
    return [box.x + edge + point.x / plot.width * (box.width - 2 * edge), box.y + edge + point.y / plot.height * (box.height - 2 * edge)];
  };
  const hide = () => { tip.hidden = ring.hidden = true; };
  // What there is to be told of a place of the window, inside `layer`.
  const say = (layer, x, y, {text, where, command, series}) => {
    layer.append(ring, tip);
    tip.querySelector('i').textContent = series || '';
    tip.querySelector('b').textContent = text;
    tip.querySelector('span').textContent = where;
    tip.querySelector('code').textContent = command;
    tip.hidden = ring.hidden = false;
    ring.style.transform = `translate(${x}px,${y}px)`;
    const [w, h] = [tip.offsetWidth, tip.offsetHeight];
    tip.style.transform = `translate(${clamp(x - w / 2, 4, Math.max(4, document.documentElement.clientWidth - w - 4))}px,${y > h + 20 ? y - h - 14 : y + 14}px)`;
  };
  const show = (image, plot, point) => say(image.closest('dialog') || document.body, ...place(image, plot, point), point);
  addEventListener('scroll', hide, {passive: true});
  addEventListener('keydown', (event) => { if (event.key === 'Escape') hide(); });
  return {
    hide,
    say,
    // The point nearest to a place of the window, if it is near; whether there was one.
    look(image, clientX, clientY, reach, picture) {
      const plot = of(image, picture);
      let best = null, least = reach;
      for (const point of plot.points) {
        const [x, y] = place(image, plot, point), away = Math.hypot(x - clientX, y - clientY);
        if (away < least) [best, least] = [point, away];
      }
      if (best) show(image, plot, best);
      else hide();
      return best !== null;
    },
    // One point on or back, from left to right.
    step(image, by) {
      const plot = of(image), order = [...plot.points].sort((a, b) => a.x - b.x || a.y - b.y);
      if (!order.length) return;
      image.dataset.point = (Number(image.dataset.point || (by > 0 ? -1 : 0)) + by + order.length) % order.length;
      show(image, plot, order[image.dataset.point]);
    }};
})();
for (const link of all('.picture a')) {
  const image = link.querySelector('img');
  link.addEventListener('pointermove', (event) => { if (event.pointerType !== 'touch') points.look(image, event.clientX, event.clientY, 14); });
  link.addEventListener('pointerleave', (event) => { if (event.pointerType !== 'touch') points.hide(); });
  link.addEventListener('blur', points.hide);
  link.addEventListener('keydown', (event) => {
    if (event.key !== 'ArrowRight' && event.key !== 'ArrowLeft') return;
    event.preventDefault();
    points.step(image, event.key === 'ArrowRight' ? 1 : -1);
  });
}
// A plot is saved as the page holds it, without the folder of the run.
for (const link of all('a[data-plot]')) link.addEventListener('click', () => { link.href = link.closest('article').querySelector('.picture img').src; });

// A pile to move about in: forces as bars, their friction as colours, weights or the response of beads as discs.
function pileScene(article, chips) {
  const pile = JSON.parse(article.querySelector('script.pile').textContent), step = Math.sqrt(3) / 2;
  const label3 = (value) => sign(String(Number(value.toPrecision(3)))), number = (value) => label3(value / 1000);
  const command = article.querySelector('.redraw code').textContent;
  const wide = pile.columns + 1, tall = pile.layers * step + 1, half = pile.columns / 2;
  const xOf = (n, i) => { const x = pile.x0 + i + (n % 2) / 2; return x >= half ? x - pile.columns : x; };
  const mix = (from, to, share) => from.map((one, k) => Math.round(one + (to[k] - one) * share)).join();
  const grey = (() => { const sorted = pile.force.toSorted((a, b) => a - b); return sorted[Math.floor(0.97 * sorted.length)] || 1; })();
  const heavy = 3 * grey;
  const ends = {force: ['0', `≥ ${number(grey)}`], friction: ['0', '1'], weight: ['0', `≥ ${number(heavy)}`], response: [`≤ ${number(-500)}`, `≥ ${number(500)}`]};
  for (const one of all('input', chips)) all('b', one.nextElementSibling).forEach((end, k) => { end.textContent = ends[one.value][k]; });
  chips.querySelector('[value=response]').parentElement.hidden = !pile.response.length;
  return {
    width: wide, height: tall,
    paint(context, x, y, scale, W, H) {
      const on = Object.fromEntries(all('input', chips).map((one) => [one.value, one.checked]));
      const ink = getComputedStyle(chips).color.match(/\d+/g).slice(0, 3).map(Number);
      const circle = (X, Y) => { context.beginPath(); context.arc(X, Y, 0.46 * scale, 0, 7); context.fill(); };
      const each = (paint) => {
        for (let n = Math.max(0, Math.floor((-y / scale - 1.5) / step)); n < pile.layers; ++n) {
          const Y = y + (0.5 + n * step) * scale;
          if (Y > H + scale) break;
          for (let i = 0; i < pile.columns; ++i) {
            const X = x + (xOf(n, i) + half + 0.5) * scale;
            if (X > -scale && X < W + scale) paint(n * pile.columns + i, X, Y);
          }
        }
      };
      for (const response of [false, true]) if (response ? on.response : on.weight) each((k, X, Y) => {
        const share = response ? clamp(Math.abs(pile.response[k] || 0) / 500, 0, 1) : clamp(pile.weight[k] / heavy, 0, 1);
        if (share < 0.02) return;
        context.fillStyle = `rgba(${response ? pile.response[k] > 0 ? '214,58,47' : '43,116,196' : ink},${response ? share : 0.75 * share})`;
        circle(X, Y);
      });
      if (on.force || on.friction) each((k, X, Y) => {
        for (const side of [0, 1]) {
          const force = clamp(pile.force[2 * k + side] / grey, 0, 1);
          if (force < 0.01) continue;
          context.lineWidth = scale * (on.force ? 0.04 + 0.36 * force : 0.16);
          context.strokeStyle = on.friction ? `rgb(${mix([0, 92, 190], [240, 160, 30], pile.friction[2 * k + side] / 1000)})` : `rgba(${ink},${force})`;
          context.beginPath();
          context.moveTo(X, Y);
          context.lineTo(X + (side - 0.5) * scale, Y + step * scale);
          context.stroke();
        }
      });
      const X = x + (half + 0.5) * scale;
      context.fillStyle = `rgb(${ink})`;
      context.beginPath();
      context.moveTo(X, y + 0.1 * scale);
      context.lineTo(X - 0.3 * scale, y - 0.5 * scale);
      context.lineTo(X + 0.3 * scale, y - 0.5 * scale);
      context.fill();
    },
    // The bead at a place, in bead diameters from the upper left corner: where it is, and what it says.
    at(across, down) {
      const n = Math.round((down - 0.5) / step);
      if (n < 0 || n >= pile.layers) return null;
      const i = [...Array(pile.columns).keys()].find((one) => Math.abs(xOf(n, one) + half + 0.5 - across) <= 0.5);
      if (i === undefined) return null;
      const k = n * pile.columns + i, both = (list) => `${number(list[2 * k])} and ${number(list[2 * k + 1])}`;
      return {x: xOf(n, i) + half + 0.5, y: 0.5 + n * step, command,
        text: `x = ${label3(xOf(n, i))}, z = ${(0.5 + n * step).toFixed(2)}: weight ${number(pile.weight[k])}${pile.response.length ? `, response ${number(pile.response[k])}` : ''}`,
        where: `Contacts to the lower left and right: forces ${both(pile.force)}, |T|/μN ${both(pile.friction)}; layer ${n}.`};
    }};
}

// A picture over the whole window: drag or pinch, wheel, + and −, arrow keys; Escape closes.
function closeLook(dialog) {
  const view = dialog.querySelector('.view'), image = view.appendChild(document.createElement('img')), canvas = view.appendChild(document.createElement('canvas'));
  const chips = dialog.querySelector('.layers'), fingers = new Map();
  let scale = 1, smallest = 1, x = 0, y = 0, shown = image, pressed = null, pile = null;
  const size = () => pile ? [pile.width, pile.height] : [image.naturalWidth, image.naturalHeight];
  const paint = () => {
    const sharp = devicePixelRatio || 1, context = canvas.getContext('2d');
    canvas.width = view.clientWidth * sharp;
    canvas.height = view.clientHeight * sharp;
    context.setTransform(sharp, 0, 0, sharp, 0, 0);
    pile.paint(context, x, y, scale, view.clientWidth, view.clientHeight);
  };
  const place = () => {
    points.hide();
    const [w, h] = size().map((one) => one * scale), [W, H] = [view.clientWidth, view.clientHeight];
    const room = 64;  // for the buttons above and below
    x = w < W ? (W - w) / 2 : clamp(x, W - w, 0);
    y = h < H - 2 * room ? (H - h) / 2 : clamp(y, H - h - room, room);
    if (pile) paint();
    else image.style.transform = `translate(${x}px,${y}px) scale(${scale})`;
  };
  const zoom = (factor, atX = view.clientWidth / 2, atY = view.clientHeight / 2) => {
    const now = clamp(scale * factor, smallest, 20 * smallest);
    x = atX - (atX - x) * now / scale;
    y = atY - (atY - y) * now / scale;
    scale = now;
    place();
  };
  const look = (event, reach) => {
    if (!pile) return points.look(image, event.clientX, event.clientY, reach, shown);
    const bead = pile.at((event.clientX - x) / scale, (event.clientY - y) / scale);
    if (bead) points.say(dialog, x + bead.x * scale, y + bead.y * scale, bead);
    else points.hide();
  };
  const open = (picture, fractionX, fractionY) => {
    const article = picture.closest('article');
    shown = picture;
    pile = article.querySelector('script.pile') ? pileScene(article, chips) : null;
    chips.hidden = canvas.hidden = !pile;
    image.hidden = Boolean(pile);
    if (!pile) {
      image.className = picture.className;
      image.alt = picture.alt;
      image.src = picture.currentSrc || picture.src;
    }
    dialog.showModal();
    const fit = () => {
      const [w, h] = size(), [across, down] = [view.clientWidth / w, view.clientHeight / h];
      smallest = Math.min(across, down);
      scale = clamp(Math.max(across, down), 1.5 * smallest, 4 * smallest);
      x = view.clientWidth / 2 - fractionX * w * scale;
      y = view.clientHeight / 2 - fractionY * h * scale;
      place();
    };
    if (pile) fit();
    else image.decode().catch(() => {}).then(fit);
  };
  chips.addEventListener('change', paint);
  for (const tool of all('.touch')) {
    tool.hidden = false;
    tool.querySelector('button').addEventListener('click', () => open(tool.closest('article').querySelector('.picture img'), 0.5, 0));
  }
  all('.picture a').forEach((link) => link.addEventListener('click', (event) => {
    if (event.ctrlKey || event.metaKey || event.shiftKey || event.altKey) return;
    event.preventDefault();
    const picture = link.querySelector('img');
    if (event.pointerType === 'touch' && points.look(picture, event.clientX, event.clientY, 24)) return;
    points.hide();
    const box = picture.getBoundingClientRect();
    const byKey = event.detail === 0;  // Enter has no place
    open(picture, byKey ? 0.5 : (event.clientX - box.x) / box.width, byKey ? 0.5 : (event.clientY - box.y) / box.height);
  }));
  const middle = (points) => points.reduce(([a, b], one) => [a + one.clientX / points.length, b + one.clientY / points.length], [0, 0]);
  const spread = ([a, b]) => b ? Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY) : 1;
  view.addEventListener('pointerdown', (event) => {
    fingers.set(event.pointerId, event);
    pressed = event;
    try { view.setPointerCapture(event.pointerId); } catch { /* of a pointer that is gone already */ }
    event.preventDefault();
  });
  view.addEventListener('pointermove', (event) => {
    if (!fingers.has(event.pointerId)) {
      look(event, 14);
      return;
    }
    const before = [...fingers.values()];
    fingers.set(event.pointerId, event);
    const after = [...fingers.values()], [fromX, fromY] = middle(before), [toX, toY] = middle(after);
    x += toX - fromX;
    y += toY - fromY;
    zoom(spread(after) / Math.max(spread(before), 1), toX, toY);
  });
  for (const end of ['pointerup', 'pointercancel']) view.addEventListener(end, (event) => {
    const still = pressed && Math.hypot(event.clientX - pressed.clientX, event.clientY - pressed.clientY) < 6;
    if (fingers.delete(event.pointerId) && still) look(event, 24);
  });
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
  dialog.addEventListener('close', () => { points.hide(); fingers.clear(); image.removeAttribute('src'); });
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
  let result = best.find((one) => one.scanned === '0.3') || best[Math.floor((best.length - 1) / 2)], at = 0, panels = {};

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

    const centre = one.fitted ? one.x_p : result.atSlope(one.z).x_p || 0;
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
      const highest = Math.max(0, ...known.map((depth) => depth[number].value + depth[number].error)) || 1;
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
    const command = byId('explore-command');
    if (command) command.textContent = command.dataset.words.replace('{scanned}', result.scanned).replace('{layer}', text.layer);
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
    const numbers = {x: label(bead.x, bead.x % 1 ? 1 : 0), P: measured(bead.P, bead.error), fit: label(bead.fit, digits), residual: label(bead.residual, 1)};
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
