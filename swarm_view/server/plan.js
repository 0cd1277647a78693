// *Plan*: the swarm from above on a canvas of its own, which costs no WebGL (swarm_view/page/plan.py
// sends what it draws). All lengths are metres in the map frame.
const plan = {
  isOn: false, isDark: false, still: null, crew: { names: [], shapes: [], kinds: [] }, poses: [],
  told: { colors: [], waits: [], chain: [], chosen: -1, tubes: [], ways: [], queues: [], movers: [] },
  scale: 0, x: 0, y: 0, isMine: false, aim: "", drag: null, map: null, follows: false,
  goal: null, start: null, since: 0, period: 100, drawn: 0,
};
swarm.plan = plan;
plan.MARK = 13; // [px] least radius of a mark, where the nearest neighbour leaves room
plan.PANEL = 340; // [px] that the panel covers on wide pages
plan.STRIP = 150; // [px] of the time line
plan.GLIDE = 150; // [ms] at most until robots are where they were said to be
plan.JUMP = 4000; // [mm] or [mrad] from which they do not glide
plan.TURN = 2000 * Math.PI; // [mrad]
plan.FRAME = 15; // [ms] between two pictures, at least
plan.RIM = 48; // [px] around the hall, for names and coordinates
plan.STEPS = [0.5, 1, 2, 5, 10, 20, 50, 100]; // [m] between two coordinates
plan.APART = 60; // [px] between them, at least

plan.show = (isOn) => {
  plan.isOn = isOn;
  document.body.toggleAttribute("data-swarm-plan", isOn);
  if (!isOn) return plan.box?.remove();
  if (!plan.box) plan.make();
  document.body.append(plan.box);
  plan.redraw();
};
plan.make = () => {
  const box = (plan.box = document.createElement("div"));
  box.id = "swarm-plan";
  box.style = "position:fixed;inset:0;z-index:5;touch-action:none;outline:none";
  box.addEventListener("wheel", plan.onWheel, { passive: false });
  box.addEventListener("pointerdown", plan.onDown);
  box.addEventListener("pointermove", plan.onMove);
  box.addEventListener("pointerup", plan.onUp);
  box.addEventListener("pointercancel", () => (plan.drag = null));
  window.addEventListener("resize", () => plan.redraw());
  plan.canvas = document.createElement("canvas");
  plan.reading = document.createElement("div"); // where the pointer is
  plan.reading.style = "position:absolute;left:16px;top:12px;font:13px system-ui,sans-serif;pointer-events:none";
  box.append(plan.canvas, plan.reading);
};
plan.setStill = (still) => {
  plan.still = still;
  plan.map = new Image();
  plan.map.onload = plan.redraw;
  plan.map.src = still.image;
  plan.isDark = still.isDark;
  plan.redraw();
};
plan.setCrew = (crew) => {
  plan.crew = crew;
  plan.redraw();
};
// Poses come in bursts, several at once where the browser is busy: robots glide to the last ones.
plan.move = (poses) => {
  const now = performance.now(), isNew = plan.goal?.length !== poses.length;
  if (isNew) plan.poses = poses;
  else if (now - plan.since > 5) plan.period = Math.min(plan.GLIDE, 0.7 * plan.period + 0.3 * (now - plan.since));
  [plan.start, plan.goal, plan.since] = [plan.poses, poses, now];
  plan.redraw();
};
plan.glide = () => {
  if (plan.poses === plan.goal || !plan.goal) return;
  const share = (performance.now() - plan.since) / plan.period;
  if (share >= 1) return void (plan.poses = plan.goal);
  plan.poses = plan.goal.map((goal, at) => {
    const gap = goal - plan.start[at];
    const way = at % 3 === 2 ? gap - plan.TURN * Math.round(gap / plan.TURN) : gap;
    return Math.abs(way) > plan.JUMP ? goal : plan.start[at] + share * way;
  });
  plan.redraw();
};
plan.tell = (told) => {
  plan.told = told;
  plan.redraw();
};
plan.fit = () => {
  plan.isMine = false;
  plan.redraw();
};
plan.redraw = () => {
  if (plan.isOn && !plan.isDue) {
    plan.isDue = true;
    requestAnimationFrame(plan.turn);
  }
};
plan.turn = (now) => {
  if (now - plan.drawn < plan.FRAME - 1) return requestAnimationFrame(plan.turn);
  plan.isDue = false;
  plan.drawn = now;
  plan.glide();
  plan.draw();
};

// Where things are on the page.
plan.free = () => {
  const isWide = innerWidth > 900;
  return [innerWidth - (isWide ? plan.PANEL : 0), innerHeight - (isWide ? plan.STRIP : 0.45 * innerHeight)];
};
plan.place = () => {
  if (plan.isMine || !plan.still) return;
  const [width, height] = plan.free();
  const { x, y, width: wide, height: high } = plan.still;
  plan.scale = 0.94 * Math.min(width / wide, height / high);
  plan.x = x + wide / 2 + (innerWidth - width) / 2 / plan.scale;
  plan.y = y + high / 2 - (innerHeight - height) / 2 / plan.scale;
};
plan.pixel = (x, y) => [
  innerWidth / 2 + (x - plan.x) * plan.scale, innerHeight / 2 - (y - plan.y) * plan.scale,
];
plan.point = (event) => [
  plan.x + (event.clientX - innerWidth / 2) / plan.scale, plan.y - (event.clientY - innerHeight / 2) / plan.scale,
];

// Radius of each mark [px]: at least plan.MARK, but no more than half the gap to the nearest neighbour;
// never less than the robot's own size.
plan.radii = (spots, own) => {
  const cell = 2 * plan.MARK, cells = new Map();
  spots.forEach(([x, y], index) => {
    const key = `${Math.floor(x / cell)},${Math.floor(y / cell)}`;
    cells.set(key, [...(cells.get(key) ?? []), index]);
  });
  return spots.map(([x, y], index) => {
    let gap = 2 * plan.MARK;
    for (let i = -1; i <= 1; i += 1)
      for (let j = -1; j <= 1; j += 1)
        for (const other of cells.get(`${Math.floor(x / cell) + i},${Math.floor(y / cell) + j}`) ?? [])
          if (other !== index) gap = Math.min(gap, Math.hypot(spots[other][0] - x, spots[other][1] - y));
    return Math.max(own[index], Math.min(plan.MARK, 0.48 * gap));
  });
};
plan.spots = () => plan.crew.names.map((_, index) => plan.pixel(plan.poses[3 * index] / 1000, plan.poses[3 * index + 1] / 1000));

// The canvas covers the hall and a rim, not all of the page: without a GPU each pixel of it costs.
plan.cover = (ratio) => {
  const { x, y, width, height } = plan.still, canvas = plan.canvas;
  const [left, top] = plan.pixel(x, y + height), [right, low] = plan.pixel(x + width, y);
  const from = [Math.max(0, Math.floor(left - plan.RIM)), Math.max(0, Math.floor(top - plan.RIM))];
  const to = [Math.min(innerWidth, Math.ceil(right + plan.RIM)), Math.min(innerHeight, Math.ceil(low + plan.RIM))];
  const [wide, high] = [Math.max(1, to[0] - from[0]), Math.max(1, to[1] - from[1])];
  const [pixels, lines] = [Math.round(wide * ratio), Math.round(high * ratio)];
  if (canvas.width !== pixels || canvas.height !== lines) [canvas.width, canvas.height] = [pixels, lines];
  const style = `position:absolute;left:${from[0]}px;top:${from[1]}px;width:${wide}px;height:${high}px`;
  if (plan.style !== style) canvas.style = plan.style = style;
  plan.rect = [...from, wide, high];
};
plan.draw = () => {
  const canvas = plan.canvas, ratio = swarm.isSoftware ? 1 : devicePixelRatio, { told, crew, poses, still } = plan;
  const ink = plan.isDark ? "#f1f3f5" : "#16191c";
  plan.box.style.background = plan.paper = plan.isDark ? "#14171b" : "#c0c5cb";
  if (!still || poses.length < 3 * crew.names.length) return;
  if (plan.follows && told.chosen >= 0)
    [plan.isMine, plan.x, plan.y, plan.scale] = [true, poses[3 * told.chosen] / 1000, poses[3 * told.chosen + 1] / 1000,
      Math.max(plan.scale, 45)];
  plan.place();
  plan.cover(ratio);
  // without a GPU, a canvas that the processor draws is several times as fast
  const context = canvas.getContext("2d", { willReadFrequently: swarm.isSoftware });
  context.setTransform(ratio, 0, 0, ratio, -ratio * plan.rect[0], -ratio * plan.rect[1]);
  context.fillStyle = plan.paper;
  context.fillRect(...plan.rect);
  context.imageSmoothingEnabled = false;
  const [left, top] = plan.pixel(still.x, still.y + still.height);
  if (plan.map?.complete) context.drawImage(plan.map, left, top, still.width * plan.scale, still.height * plan.scale);
  context.lineJoin = context.lineCap = "round";
  const trace = (points) => {
    context.beginPath();
    for (let at = 0; at < points.length; at += 2)
      context[at ? "lineTo" : "moveTo"](...plan.pixel(points[at] / 1000, points[at + 1] / 1000));
  };
  for (const [index, points] of told.tubes) {
    trace(points);
    context.strokeStyle = `${told.colors[index] ?? "#888888"}55`;
    context.lineWidth = Math.max(3, 2 * (crew.shapes[crew.kinds[index]]?.inner ?? 0.2) * plan.scale);
    context.stroke();
  }
  context.setLineDash([5, 4]);
  for (const [index, points] of told.ways) {
    trace(points);
    context.strokeStyle = told.colors[index] ?? "#888888";
    context.lineWidth = index === told.chosen ? 2.5 : 1.2;
    context.stroke();
  }
  context.setLineDash([]);
  for (const { points, color } of told.movers) {
    trace(points);
    context.closePath();
    context.fillStyle = color;
    context.fill();
    context.strokeStyle = ink;
    context.lineWidth = 1;
    context.stroke();
  }
  plan.drawLayout(context);
  plan.drawStations(context);
  const spots = plan.spots();
  const own = crew.kinds.map((kind) => (crew.shapes[kind]?.radius ?? 0.2) * plan.scale);
  plan.sizes = plan.radii(spots, own);
  spots.forEach((spot, index) => plan.drawRobot(context, index, spot, own[index], ink));
  plan.drawWaits(context, spots);
  if (spots[told.chosen]) plan.drawRing(context, spots[told.chosen], plan.sizes[told.chosen], ink);
  const taken = []; // boxes of names
  plan.nameStations(context, spots, ink, taken);
  plan.drawNames(context, spots, ink, taken);
  plan.drawAxes(context, ink);
  plan.drawDrag(context, ink);
};
// Coordinates in map [m] below the hall and left of it, or at the rim of what is seen of it.
plan.drawAxes = (context, ink) => {
  const { x, y, width, height } = plan.still, [, top, , high] = plan.rect, [, free] = plan.free();
  const step = plan.STEPS.find((one) => one * plan.scale >= plan.APART) ?? plan.STEPS.at(-1);
  const [, end] = plan.pixel(x, y), low = Math.min(end, top + high - 18, free - 18), rim = plan.rim();
  const marks = (from, length) =>
    Array.from({ length: Math.floor((from + length) / step) - Math.ceil(from / step) + 1 }, (_, n) => (Math.ceil(from / step) + n) * step);
  context.font = "11px system-ui, sans-serif";
  context.strokeStyle = ink;
  context.lineWidth = 1;
  context.beginPath();
  for (const at of marks(x, width)) {
    const [right] = plan.pixel(at, y);
    context.moveTo(right, low);
    context.lineTo(right, low + 4);
    plan.write(context, `${at}`, right, low + 15, ink);
  }
  for (const at of marks(y, height)) {
    const [, down] = plan.pixel(x, at);
    context.moveTo(rim, down);
    context.lineTo(rim - 4, down);
    plan.write(context, `${at}`, rim - 6, down + 4, ink, "right");
  }
  context.strokeStyle = ink;
  context.lineWidth = 1;
  context.stroke();
};
// The layout of a fleet control: dots at its nodes, lines from node to node; numbers are millimetres.
plan.drawLayout = (context) => {
  const [nodes, ends] = plan.still.layout, at = (list, index) => plan.pixel(list[index] / 1000, list[index + 1] / 1000);
  context.strokeStyle = context.fillStyle = plan.isDark ? "#91a7ff" : "#4c5fc0";
  context.lineWidth = 1;
  context.beginPath();
  for (let index = 0; index < ends.length; index += 4) {
    context.moveTo(...at(ends, index));
    context.lineTo(...at(ends, index + 2));
  }
  context.stroke();
  for (let index = 0; index < nodes.length; index += 2) {
    const [right, down] = at(nodes, index);
    context.fillRect(right - 2, down - 2, 4, 4);
  }
};
plan.drawStations = (context) => {
  for (const [, x, y] of plan.still.stations) {
    const [right, down] = plan.pixel(x, y), size = plan.stationSize();
    context.strokeStyle = plan.isDark ? "#38d9a9" : "#00694d";
    context.lineWidth = 2.5;
    context.strokeRect(right - size, down - size, 2 * size, 2 * size);
  }
};
// [px] of the line at whose left the numbers stand
plan.rim = () => Math.max(plan.pixel(plan.still.x, plan.still.y)[0], plan.rect[0] + 34);
plan.stationSize = () => Math.max(5, 0.3 * plan.scale);
// A name lies above its station, or below or beside it where robots are; numbers stand for the robots.
plan.nameStations = (context, spots, ink, taken) => {
  context.font = "12px system-ui, sans-serif";
  const [left, , wide] = plan.rect, size = plan.stationSize();
  for (const [name, x, y] of plan.still.stations) {
    const [right, down] = plan.pixel(x, y), queue = plan.told.queues.find(([station]) => station === name);
    const robots = queue && (plan.told.names ? queue[1] : queue[1].replace(/[A-Za-z_]+(?=\d)/g, ""));
    const text = robots ? `${name} ← ${robots}` : name, half = context.measureText(text).width / 2 + 3;
    const fit = (middle) => Math.max(plan.rim() + half, Math.min(left + wide - half, middle));
    const places = [
      [fit(right), down - size - 6], [fit(right), down + size + 15],
      [fit(right + size + half + 3), down + 4], [fit(right - size - half - 3), down + 4],
    ].map(([middle, line]) => [middle, line, [middle - half, line - 11, middle + half, line + 3]]);
    const hits = places.map(([, , box]) =>
      spots.filter((spot, index) => plan.covers(spot, plan.sizes[index], box)).length + taken.filter((one) => plan.meets(one, box)).length);
    const [middle, line, box] = places[hits.indexOf(Math.min(...hits))];
    taken.push(box);
    plan.write(context, text, middle, line, ink);
  }
};
plan.meets = ([left, top, right, low], [l, t, r, b]) => left < r && right > l && top < b && low > t;
plan.covers = ([x, y], size, box) => plan.meets([x - size, y - size, x + size, y + size], box);
plan.write = (context, text, right, down, ink, align = "center") => {
  context.textAlign = align;
  context.lineWidth = 3.5;
  context.strokeStyle = plan.isDark ? "#14171b" : "#ffffff";
  context.strokeText(text, right, down);
  context.fillStyle = ink;
  context.fillText(text, right, down);
};
plan.drawRobot = (context, index, [right, down], own, ink) => {
  const shape = plan.crew.shapes[plan.crew.kinds[index]], yaw = plan.poses[3 * index + 2] / 1000;
  const radius = plan.sizes[index], grown = radius / Math.max(own, 1e-6);
  context.save();
  context.translate(right, down);
  context.rotate(-yaw);
  context.beginPath();
  if (shape) {
    const factor = plan.scale * grown;
    shape.corners.forEach(([x, y], at) =>
      context[at ? "lineTo" : "moveTo"]((x - shape.middle[0]) * factor, -(y - shape.middle[1]) * factor));
    context.closePath();
  } else context.arc(0, 0, radius, 0, 7);
  context.fillStyle = plan.told.colors[index] ?? "#ffffff";
  context.fill();
  context.lineWidth = radius > 6 ? 1.4 : 0.8;
  context.strokeStyle = ink;
  context.stroke();
  const tip = 0.85 * radius; // an arrow head towards the robot's front
  context.beginPath();
  context.moveTo(tip, 0);
  context.lineTo(-0.35 * tip, -0.55 * tip);
  context.lineTo(-0.1 * tip, 0);
  context.lineTo(-0.35 * tip, 0.55 * tip);
  context.closePath();
  context.fillStyle = "#ffffff";
  context.fill();
  context.lineWidth = 0.7;
  context.strokeStyle = "#16191c";
  context.stroke();
  context.restore();
};
plan.drawWaits = (context, spots) => {
  const glowing = new Set(plan.told.chain);
  for (const [from, to] of plan.told.waits) {
    if (!spots[from] || !spots[to]) continue;
    const [[x0, y0], [x1, y1]] = [spots[from], spots[to]];
    const length = Math.hypot(x1 - x0, y1 - y0) || 1;
    const [ux, uy] = [(x1 - x0) / length, (y1 - y0) / length];
    const [start, end] = [plan.sizes[from], Math.max(plan.sizes[from] + 1, length - plan.sizes[to])];
    const bend = 0.12 * length;
    const [mx, my] = [(x0 + x1) / 2 - uy * bend, (y0 + y1) / 2 + ux * bend];
    const draw = (color, width) => {
      context.strokeStyle = context.fillStyle = color;
      context.lineWidth = width;
      context.beginPath();
      context.moveTo(x0 + ux * start, y0 + uy * start);
      context.quadraticCurveTo(mx, my, x0 + ux * end, y0 + uy * end);
      context.stroke();
    };
    if (glowing.has(from)) draw("#ffd43bcc", 9);
    draw("#d6336c", 2);
    const angle = Math.atan2(y0 + uy * end - my, x0 + ux * end - mx);
    context.save();
    context.translate(x0 + ux * end, y0 + uy * end);
    context.rotate(angle);
    context.beginPath();
    context.moveTo(0, 0);
    context.lineTo(-9, -4.5);
    context.lineTo(-9, 4.5);
    context.fill();
    context.restore();
  }
};
plan.drawRing = (context, [right, down], radius, ink) => {
  for (const [color, width] of [[plan.isDark ? "#14171b" : "#ffffff", 7], [ink, 3]]) {
    context.beginPath();
    context.arc(right, down, radius + 7, 0, 7);
    context.lineWidth = width;
    context.strokeStyle = color;
    context.stroke();
  }
};
plan.drawNames = (context, spots, ink, taken) => {
  const { names } = plan.crew;
  const order = names.map((_, index) => index).sort((a, b) => (b === plan.told.chosen) - (a === plan.told.chosen));
  context.font = "11px system-ui, sans-serif";
  for (const index of order) {
    const isChosen = index === plan.told.chosen, [right, down] = spots[index];
    const text = isChosen || plan.told.names ? names[index] : names[index].replace(/^\D+/, "");
    const wide = 6.4 * text.length + 4, x = right + plan.sizes[index] + 3 + (isChosen ? 8 : 0), y = down + 4;
    const box = [x, y - 10, x + wide, y + 3];
    const covers = spots.some((spot, other) => other !== index && plan.covers(spot, plan.sizes[other], box));
    if (!isChosen && (covers || taken.some((one) => plan.meets(one, box)))) continue;
    taken.push(box);
    plan.write(context, text, x, y, ink, "left");
  }
};
plan.drawDrag = (context, ink) => {
  const drag = plan.drag;
  if (!drag || drag.kind === "pan" || !drag.hasMoved) return;
  const [x0, y0] = plan.pixel(...drag.start), [x1, y1] = plan.pixel(...drag.now);
  context.strokeStyle = context.fillStyle = ink;
  context.lineWidth = 2.5;
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
  context.beginPath();
  context.arc(x1, y1, drag.kind === "carry" ? 10 : 4, 0, 7);
  context.stroke();
};

// The mouse: pan, zoom, choose a robot, use a tool, carry a robot or an object.
plan.onWheel = (event) => {
  event.preventDefault();
  const before = plan.point(event);
  plan.isMine = true;
  plan.scale = Math.min(600, Math.max(1, plan.scale * Math.exp(-0.0015 * event.deltaY)));
  const after = plan.point(event);
  plan.x += before[0] - after[0];
  plan.y += before[1] - after[1];
  plan.redraw();
};
plan.robotAt = (event) => {
  let best = -1, least = Infinity;
  plan.spots().forEach(([x, y], index) => {
    const gap = Math.hypot(event.clientX - x, event.clientY - y) - Math.max(6, plan.sizes?.[index] ?? 0);
    if (gap < Math.min(least, 4)) [best, least] = [index, gap];
  });
  return best;
};
plan.moverAt = ([x, y]) =>
  plan.told.movers.find(({ points }) => {
    let isInside = false;
    for (let at = 0, before = points.length - 2; at < points.length; before = at, at += 2) {
      const [ax, ay, bx, by] = [points[at], points[at + 1], points[before], points[before + 1]];
      if (ay > 1000 * y !== by > 1000 * y && 1000 * x < ((bx - ax) * (1000 * y - ay)) / (by - ay) + ax)
        isInside = !isInside;
    }
    return isInside;
  });
plan.stationAt = ([x, y]) => {
  const reach = plan.stationSize() / plan.scale;
  return plan.still?.stations.find(([, a, b]) => Math.abs(a - x) < reach && Math.abs(b - y) < reach)?.[0];
};
plan.waitAt = (event) => {
  const spots = plan.spots();
  return plan.told.waits.find(([from, to]) => {
    const [[x0, y0], [x1, y1]] = [spots[from] ?? [0, 0], spots[to] ?? [0, 0]];
    const along = ((event.clientX - x0) * (x1 - x0) + (event.clientY - y0) * (y1 - y0)) / ((x1 - x0) ** 2 + (y1 - y0) ** 2 || 1);
    const t = Math.min(1, Math.max(0, along));
    return Math.hypot(event.clientX - x0 - t * (x1 - x0), event.clientY - y0 - t * (y1 - y0)) < 10;
  });
};
plan.onDown = (event) => {
  const start = plan.point(event), robot = plan.robotAt(event);
  plan.box.setPointerCapture(event.pointerId);
  let kind = plan.aim ? "tool" : "pan", name = "";
  if (plan.aim === "Move") {
    name = robot >= 0 ? plan.crew.names[robot] : (plan.moverAt(start)?.name ?? plan.stationAt(start) ?? "");
    kind = name ? "carry" : "pan";
  }
  plan.drag = { kind, name, start, now: start, robot, at: [event.clientX, event.clientY], hasMoved: false };
};
plan.onMove = (event) => {
  const drag = plan.drag, [x, y] = plan.point(event);
  plan.reading.style.color = plan.isDark ? "#f1f3f5" : "#16191c";
  plan.reading.textContent = plan.still ? `x ${x.toFixed(2)}  y ${y.toFixed(2)} m` : "";
  if (!drag) return;
  drag.hasMoved ||= Math.hypot(event.clientX - drag.at[0], event.clientY - drag.at[1]) > 4;
  if (drag.kind === "pan" && drag.hasMoved) {
    const now = plan.point(event);
    plan.isMine = true;
    plan.follows = false;
    plan.x += drag.start[0] - now[0];
    plan.y += drag.start[1] - now[1];
  } else drag.now = plan.point(event);
  plan.redraw();
};
plan.onUp = (event) => {
  const drag = plan.drag;
  plan.drag = null;
  if (!drag) return;
  if (drag.kind === "tool") swarm.send("plan-tool", [...drag.start, ...(drag.hasMoved ? drag.now : drag.start)]);
  else if (drag.kind === "carry" && drag.hasMoved) swarm.send("plan-carry", [drag.name, ...drag.start, ...drag.now]);
  else if (!drag.hasMoved) {
    const wait = drag.robot < 0 && plan.waitAt(event);
    if (wait) swarm.send("follow-chain", plan.crew.names[wait[0]]);
    else if (drag.robot >= 0) swarm.send("select", plan.crew.names[drag.robot]);
    else swarm.send("plan-floor", drag.start);
  }
  plan.redraw();
};

// While it is shown, the scene behind it is not drawn.
for (const name of ["drawElements", "drawArrays", "drawElementsInstanced", "drawArraysInstanced", "multiDrawElementsWEBGL"]) {
  const draw = WebGL2RenderingContext.prototype[name];
  if (draw)
    WebGL2RenderingContext.prototype[name] = function (...values) {
      if (!plan.isOn) return draw.apply(this, values);
    };
}
