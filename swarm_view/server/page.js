// What our page does beside viser's client. `swarm.send(kind, value)` brings something to Python,
// as a change of a hidden text field (swarm_view/page/inbox.py) by viser's own message.
const swarm = { worker: null, inbox: null, count: 0, waiting: [] };
window.swarm = swarm;

swarm.send = (kind, value) => {
  if (swarm.worker === null || swarm.inbox === null) {
    swarm.waiting.push([kind, value]);
    return;
  }
  swarm.count += 1;
  const text = JSON.stringify({ kind, value, count: swarm.count });
  swarm.worker.postMessage({
    type: "send",
    message: { type: "GuiUpdateMessage", uuid: swarm.inbox, updates: { value: text } },
  });
};

swarm.begin = (inbox) => {
  swarm.inbox = inbox;
  if (innerWidth < swarm.PHONE) swarm.foldPanel();
  for (const [kind, value] of swarm.waiting.splice(0)) swarm.send(kind, value);
  swarm.tellSize();
};

// On a phone viser's panel lies over the page: it opens at a tap on its head.
swarm.PHONE = 576; // [px] of a page's width, below which viser has that panel
swarm.foldPanel = (tries = 10) => {
  const heads = [...document.querySelectorAll("div")].filter((one) => one.style.height === "3.5em" && one.style.cursor === "pointer");
  if (heads.length) heads[0].click();
  else if (tries) setTimeout(() => swarm.foldPanel(tries - 1), 200);
};

swarm.tellSize = () => swarm.send("size", [window.innerWidth, window.innerHeight]);
window.addEventListener("resize", () => swarm.inbox !== null && swarm.tellSize());

// viser's client connects to the page's address without its query. This hands the query on.
const post = Worker.prototype.postMessage;
Worker.prototype.postMessage = function (message, ...rest) {
  if (message && message.type === "set_server") {
    swarm.worker = this;
    if (!message.server.includes("?"))
      message = { ...message, server: message.server + location.search };
  }
  return post.call(this, message, ...rest);
};

// A page that is left is closed, not kept for a way back: frozen, it would hold its connection until
// the viewer gives up on it, 40 s later, and the swarm would go on to draw for it.
window.addEventListener("pagehide", () => swarm.worker?.terminate());
window.addEventListener("pageshow", (event) => event.persisted && location.reload());

// Without a GPU every sample of a pixel costs, and so does viser's background, which is a picture in
// front of the camera: smooth edges are left to GPUs, and the background is what the scene is cleared to.
swarm.gl = null;
swarm.background = [0.75, 0.77, 0.8];
swarm.isSoftware = (() => {
  const gl = document.createElement("canvas").getContext("webgl2");
  const name = gl?.getExtension("WEBGL_debug_renderer_info")?.UNMASKED_RENDERER_WEBGL;
  const renderer = name ? gl.getParameter(name) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|softpipe|basic render/i.test(renderer);
})();
const getContext = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (type, options) {
  if (type !== "webgl2") return getContext.call(this, type, options);
  const antialias = options?.antialias && !swarm.isSoftware;
  const gl = getContext.call(this, type, { ...options, antialias });
  if (gl && options) {
    swarm.gl = gl;
    swarm.setBackground(swarm.background);
  }
  return gl;
};
const attachShader = WebGL2RenderingContext.prototype.attachShader;
WebGL2RenderingContext.prototype.attachShader = function (program, shader) {
  attachShader.call(this, program, shader);
  if (!this.getShaderSource(shader).includes("uniform bool hasDepth;")) return;
  for (const other of this.getAttachedShaders(program)) {
    if (other === shader) continue; // viser's background: put out of sight before it costs pixels
    const source = this.getShaderSource(other);
    this.shaderSource(other, source.replace(/gl_Position = [^;]*;/, "gl_Position = vec4(2, 2, 2, 1);"));
    this.compileShader(other);
  }
};
const clearColor = WebGL2RenderingContext.prototype.clearColor;
WebGL2RenderingContext.prototype.clearColor = function (red, green, blue, alpha) {
  return clearColor.call(this, ...(alpha ? [red, green, blue, alpha] : [...swarm.background, 1]));
};
swarm.setBackground = (color) => {
  swarm.background = color;
  if (swarm.gl) clearColor.call(swarm.gl, ...color, 1);
};

// react-three-fiber makes it passive; viser's client prevents its default when a drag begins.
const listen = EventTarget.prototype.addEventListener;
EventTarget.prototype.addEventListener = function (type, listener, options) {
  if (type === "pointerdown" && options && options.passive)
    options = { ...options, passive: false };
  return listen.call(this, type, listener, options);
};

document.title =
  "swarm" + (new URLSearchParams(location.search).get("robot") ?? "").replace(/^(.)/, " · $1");

// The time line: its HTML says what a click means.
document.addEventListener("click", (event) => {
  const sender = event.target.closest?.("[data-swarm-send]");
  if (sender) {
    const { swarmSend, swarmValue, swarmText } = sender.dataset;
    swarm.send(swarmSend, swarmText ?? Number(swarmValue));
    return;
  }
  const line = event.target.closest?.("[data-swarm-line]");
  if (line) {
    const box = line.getBoundingClientRect();
    const [start, end] = [Number(line.dataset.start), Number(line.dataset.end)];
    swarm.send("seek", start + ((event.clientX - box.left) / box.width) * (end - start));
  }
});

// What is said in the middle of the page: by Python, or here when Python says nothing any more.
swarm.SILENCE = 10000; // [ms]
swarm.heard = 0; // [ms] when Python last told the time, which it does once a second; 0: never yet
swarm.said = "";
swarm.notice = (text) => {
  swarm.said = text;
  swarm.showNotice(text);
};
swarm.showNotice = (text) => {
  let box = document.getElementById("swarm-notice");
  if (!box) {
    box = document.createElement("div");
    box.id = "swarm-notice";
    box.style =
      "position:fixed;left:50%;top:40%;transform:translate(-50%,-50%);z-index:1000;padding:0.8em 1.4em;" +
      "max-width:80vw;border-radius:8px;background:#22262bee;color:#fff;font:1.1rem sans-serif;" +
      "text-align:center;pointer-events:none";
    document.body.append(box);
  }
  box.textContent = text;
  box.hidden = !text;
};
swarm.end = (text) => {
  clearInterval(swarm.watch);
  swarm.notice(text);
};
swarm.watch = setInterval(() => {
  if (!swarm.heard) return;
  const isSilent = Date.now() - swarm.heard > swarm.SILENCE;
  const text = "The viewer does not answer. If its run has ended, this page shows its last moment.";
  swarm.showNotice(isSilent ? text : swarm.said);
}, 1000);

// The button of a tool that waits for a click looks pressed, and the pointer over the scene is a cross.
document.addEventListener("DOMContentLoaded", () => {
  const style = document.createElement("style");
  style.textContent =
    "button[data-swarm-pressed]{background:#1864ab !important;color:#fff !important;" +
    "box-shadow:inset 0 2px 4px #0008}" +
    "body[data-swarm-aiming] :is(canvas, #swarm-plan){cursor:crosshair !important}" +
    // viser's own hints would lie below its panel
    ".mantine-Tooltip-tooltip{z-index:2000 !important;font-size:0.85rem;line-height:1.35}" +
    "body[data-swarm-plan] canvas[data-engine]{visibility:hidden}" +
    // a folder that is closed is a line with a name, not a box that looks like an empty field
    ".mantine-Paper-root:has(> .mantine-Paper-root > .tabler-icon-chevron-down)" +
    "{border-width:1px 0 0 0 !important;border-radius:0;background:none;margin-bottom:0 !important}" +
    // One primary button in each tab; all others are outlines. Grey text is dark enough to be read.
    ".mantine-Button-root:not([data-swarm-primary]):not([data-swarm-pressed])" +
    "{background:transparent !important;color:inherit !important;border:1px solid #868e96 !important}" +
    ".mantine-Button-root[data-swarm-primary]{background:#1864ab !important;color:#fff !important}" +
    ".mantine-Button-root:disabled{opacity:0.75}" +
    ":root[data-mantine-color-scheme=light]{--mantine-color-dimmed:#495057 !important}" +
    ":root[data-mantine-color-scheme=dark]{--mantine-color-dimmed:#c1c7cd !important;" +
    "--mantine-primary-color-filled:#4dabf7 !important}" +
    "[data-dock-tab][aria-selected=true]{color:#1864ab !important}" +
    ":root[data-mantine-color-scheme=dark] [data-dock-tab][aria-selected=true]{color:#74c0fc !important}" +
    "[data-swarm-hidden]{display:none !important}" +
    "#swarm-past{position:fixed;inset:0;border:6px solid #e67700;z-index:900;pointer-events:none}" +
    "#swarm-past span{position:absolute;top:0;left:50%;transform:translateX(-50%);padding:0.3em 1em;" +
    "background:#e67700;color:#16191c;font:600 0.95rem sans-serif;border-radius:0 0 8px 8px;" +
    "white-space:nowrap;max-width:96vw;overflow:hidden;text-overflow:ellipsis}" +
    "#swarm-keys{position:fixed;inset:0;margin:auto;width:min(30rem,92vw);height:fit-content;z-index:1500;" +
    "background:#fff;color:#16191c;border-radius:10px;padding:1rem 1.4rem;box-shadow:0 8px 40px #0008;" +
    "font:0.95rem/1.7 sans-serif}" +
    "#swarm-keys kbd{display:inline-block;min-width:5.5em;font-weight:600}";
  document.head.append(style);
});
swarm.press = (label) => {
  if (swarm.plan) swarm.plan.aim = label;
  for (const button of document.querySelectorAll("button"))
    button.toggleAttribute("data-swarm-pressed", label !== "" && button.textContent.trim() === label);
  document.body.toggleAttribute("data-swarm-aiming", label !== "");
};

// Hints of buttons, by their labels: viser shows those of other widgets only.
swarm.hints = {};
document.addEventListener("mouseover", (event) => {
  const button = event.target.closest?.("button");
  const hint = button && swarm.hints[button.textContent.trim()];
  if (hint) button.title = hint;
});

// Keys of the page; what they mean to the swarm is decided in Python (`Page._press`).
swarm.keys = [
  ["Space", "play or pause what is shown"], ["← →", "a second back or on"], ["F", "follow the chosen robot"],
  ["G", "send the chosen robot to a goal"], ["P", "plan, or the hall in 3D"], ["?", "this sheet"],
  ["Esc", "drop the tool, leave the past, choose nobody"],
];
swarm.showKeys = () => {
  const shown = document.getElementById("swarm-keys");
  if (shown) return shown.remove();
  const sheet = document.createElement("div");
  sheet.id = "swarm-keys";
  sheet.innerHTML = swarm.keys.map(([key, text]) => `<div><kbd>${key}</kbd>${text}</div>`).join("");
  sheet.onclick = () => sheet.remove();
  document.body.append(sheet);
};
window.addEventListener(
  "keydown",
  (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest?.("input, textarea")) return;
    if (swarm.drive.isOn && event.code in swarm.ways) return;
    const sheet = document.getElementById("swarm-keys");
    const steps = { ArrowLeft: -10, ArrowRight: 10 };
    if (event.key === "?") swarm.showKeys();
    else if (event.key === "Escape" && sheet) sheet.remove();
    else if (event.code === "Space") swarm.send("play", 0);
    else if (event.code in steps) swarm.send("step", steps[event.code]);
    else if (["f", "g", "p", "Escape"].includes(event.key)) swarm.send("key", event.key);
    else return;
    event.preventDefault();
    event.stopImmediatePropagation(); // a button that has the focus, and viser's camera
  },
  true,
);
swarm.openTab = (name) => {
  const tab = [...document.querySelectorAll("[role=tab]")].find((one) => one.title === name);
  if (tab) tab.dispatchEvent(new KeyboardEvent("keydown", { bubbles: true, key: "Enter", code: "Enter" }));
  else setTimeout(() => swarm.openTab(name), 300);
};

// What viser draws anew: the main button of each tab, and what is not ours and stays out of sight.
swarm.primary = new Set(["Pause", "Resume", "Play", "Drive by hand", "Copy link"]);
swarm.tidy = () => {
  for (const button of document.querySelectorAll(".mantine-Button-root"))
    button.toggleAttribute("data-swarm-primary", swarm.primary.has(button.textContent.trim()));
  for (const note of document.querySelectorAll(".mantine-Notification-root"))
    if (/WebGL/.test(note.textContent)) note.toggleAttribute("data-swarm-hidden", true);
  for (const icon of document.querySelectorAll(".tabler-icon-adjustments, .tabler-icon-arrow-back"))
    icon.closest("button")?.toggleAttribute("data-swarm-hidden", true);
  if (swarm.shown) swarm.drawTime(...swarm.shown);
};
document.addEventListener("DOMContentLoaded", () => {
  new MutationObserver((changes) => {
    if (changes.some(({ addedNodes }) => [...addedNodes].some((node) => node.nodeType === 1))) swarm.tidy();
  }).observe(document.body, { childList: true, subtree: true });
});

// The past has a frame and a sentence, which stay until Python says otherwise.
swarm.showPast = (time, isPast) => {
  let frame = document.getElementById("swarm-past");
  if (!isPast) return frame?.remove();
  if (!frame) {
    frame = document.createElement("div");
    frame.id = "swarm-past";
    frame.append(document.createElement("span"));
    document.body.append(frame);
  }
  const text = `The past: ${time.toFixed(1)} s. The swarm goes on, orders wait; Esc or Live leads back.`;
  if (frame.firstChild.textContent !== text) frame.firstChild.textContent = text;
};

swarm.shown = null;
swarm.showTime = (time, isPlaying, isPast) => {
  swarm.heard = Date.now();
  swarm.shown = [time, isPlaying, isPast];
  swarm.drawTime(time, isPlaying, isPast);
};
swarm.drawTime = (time, isPlaying, isPast) => {
  swarm.showPast(time, isPast);
  for (const cursor of document.querySelectorAll("[data-swarm-now]")) {
    const { start, end } = cursor.parentElement.dataset;
    const share = (time - start) / (end - start);
    cursor.style.left = `${100 * Math.min(1, Math.max(0, share))}%`;
  }
  for (const button of document.querySelectorAll("[data-swarm-send=play]"))
    swarm.write(button, isPlaying ? "❚❚" : "▶");
  for (const clock of document.querySelectorAll("[data-swarm-clock]"))
    swarm.write(clock, `${time.toFixed(1)} s${isPast ? " · the past" : ""}${isPlaying ? "" : " · paused"}`);
};
swarm.write = (node, text) => {
  if (node.textContent !== text) node.textContent = text;
};

// Text to copy, also where browsers offer no clipboard (a page that came by plain HTTP).
swarm.copy = (text) => {
  if (navigator.clipboard) {
    navigator.clipboard.writeText(text).catch(() => swarm.copyOld(text));
  } else swarm.copyOld(text);
  swarm.send("copied", text.slice(0, 300));
};
swarm.copyOld = (text) => {
  const field = document.createElement("textarea");
  field.value = text;
  document.body.append(field);
  field.select();
  document.execCommand("copy");
  field.remove();
};
document.addEventListener("click", (event) => {
  const source = event.target.closest?.("[data-swarm-copy]");
  if (source) swarm.copy(source.dataset.swarmCopy);
});

// A film of what is shown, with clock, legend and figures, as a file of the browser's downloads.
swarm.film = null;
swarm.legend = []; // [name and number, colour] of the states that robots are in
swarm.figures = []; // [name, value] of the tab *Run*
swarm.startFilm = () => {
  const area = (canvas) => canvas.width * canvas.height; // others serve to measure text and curves
  const seen = [...document.querySelectorAll("canvas")].filter((one) => !one.closest("#swarm-plan"));
  const [scene] = seen.sort((a, b) => area(b) - area(a));
  const canvas = document.createElement("canvas"), context = canvas.getContext("2d");
  [canvas.width, canvas.height] = [innerWidth & ~1, innerHeight & ~1]; // even, as encoders want; and fixed
  const kinds = ["video/mp4;codecs=avc1", "video/webm"].filter((kind) => MediaRecorder.isTypeSupported(kind));
  const film = new MediaRecorder(canvas.captureStream(25), { mimeType: kinds[0], videoBitsPerSecond: 6e6 });
  const parts = [], began = performance.now();
  const draw = () => {
    if (film.state === "inactive") return;
    if (swarm.plan?.isOn) {
      context.fillStyle = swarm.plan.paper;
      context.fillRect(0, 0, canvas.width, canvas.height);
      context.drawImage(swarm.plan.canvas, ...swarm.plan.rect);
    } else context.drawImage(scene, 0, 0, canvas.width, canvas.height);
    swarm.drawLegend(context);
    swarm.drawFigures(context);
    requestAnimationFrame(draw);
  };
  film.ondataavailable = (event) => parts.push(event.data);
  film.onstop = async () => {
    const isWebm = film.mimeType.includes("webm");
    let content = new Uint8Array(await new Blob(parts).arrayBuffer());
    if (isWebm) content = swarm.withDuration(content, performance.now() - began);
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([content], { type: film.mimeType }));
    link.download = `${swarm.filmName}.${isWebm ? "webm" : "mp4"}`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60000);
    swarm.send("filmed", content.length);
  };
  film.start(1000);
  draw();
  swarm.film = film;
};
swarm.drawLegend = (context) => {
  context.font = "600 16px system-ui, sans-serif";
  context.textBaseline = "middle";
  let right = 16;
  const [time] = swarm.shown ?? [0];
  for (const [name, color] of [[`${time.toFixed(1)} s`, ""], ...swarm.legend]) {
    const wide = context.measureText(name).width + (color ? 22 : 0) + 16;
    context.fillStyle = "#14171bd9";
    context.fillRect(right - 8, context.canvas.height - 40, wide, 28);
    context.fillStyle = color;
    if (color) context.fillRect(right, context.canvas.height - 33, 14, 14);
    context.fillStyle = "#ffffff";
    context.fillText(name, right + (color ? 22 : 0), context.canvas.height - 26);
    right += wide;
  }
};
swarm.drawFigures = (context) => {
  const left = context.canvas.width - 350, high = 24 * swarm.figures.length + 16;
  context.font = "14px system-ui, sans-serif";
  context.fillStyle = "#14171bd9";
  if (swarm.figures.length) context.fillRect(left, 16, 334, high);
  context.fillStyle = "#ffffff";
  swarm.figures.forEach(([name, value], row) => {
    context.fillText(name, left + 12, 36 + 24 * row);
    context.fillText(value, left + 150, 36 + 24 * row, 174);
  });
};
// A WebM file that is written live has no duration: it goes into the element Info (Matroska).
swarm.withDuration = (film, milliseconds) => {
  const INFO = [0x15, 0x49, 0xa9, 0x66];
  const at = film.findIndex((_, place) => INFO.every((byte, offset) => film[place + offset] === byte));
  if (at < 0) return film;
  const length = Math.clz32(film[at + 4]) - 23; // bytes of its size
  let size = film[at + 4] & (0xff >> length);
  for (let byte = 1; byte < length; byte += 1) size = size * 256 + film[at + 4 + byte];
  const begin = at + 4 + length, body = film.subarray(begin, begin + size);
  if (body.some((byte, place) => byte === 0x44 && body[place + 1] === 0x89)) return film;
  const head = new Uint8Array(4 + 8 + 11), view = new DataView(head.buffer);
  head.set(INFO);
  view.setUint32(4, 0x01000000);
  view.setUint32(8, size + 11);
  head.set([0x44, 0x89, 0x88], 12);
  view.setFloat64(15, milliseconds);
  const result = new Uint8Array(film.length + head.length - 4 - length);
  result.set(film.subarray(0, at));
  result.set(head, at);
  result.set(film.subarray(begin), at + head.length);
  return result;
};
swarm.stopFilm = (name) => {
  swarm.filmName = name;
  swarm.film?.stop();
  swarm.film = null;
};

// Driving by hand: keys, or buttons that are held. A wish is repeated, and counts for a moment only.
swarm.drive = { isOn: false, keys: new Set(), timer: null };
swarm.ways = {
  KeyW: [1, 0], ArrowUp: [1, 0], KeyS: [-1, 0], ArrowDown: [-1, 0],
  KeyA: [0, 1], ArrowLeft: [0, 1], KeyD: [0, -1], ArrowRight: [0, -1],
};
swarm.setDriving = (isOn) => {
  const drive = swarm.drive;
  drive.isOn = isOn;
  drive.keys.clear();
  clearInterval(drive.timer);
  if (isOn) drive.timer = setInterval(swarm.tellWish, 100);
};
swarm.tellWish = () => {
  const wish = [0, 0];
  for (const key of swarm.drive.keys) {
    wish[0] += swarm.ways[key][0];
    wish[1] += swarm.ways[key][1];
  }
  swarm.send("drive", wish.map((value) => Math.max(-1, Math.min(1, value))));
};
for (const type of ["keydown", "keyup"])
  window.addEventListener(
    type,
    (event) => {
      const isTyping = event.target.closest?.("input, textarea");
      if (!swarm.drive.isOn || isTyping || !(event.code in swarm.ways)) return;
      event.preventDefault();
      event.stopImmediatePropagation(); // viser's camera uses the same keys
      if (type === "keydown") swarm.drive.keys.add(event.code);
      else swarm.drive.keys.delete(event.code);
    },
    true,
  );
window.addEventListener("blur", () => swarm.drive.keys.clear());
document.addEventListener("pointerdown", (event) => {
  const pad = event.target.closest?.("[data-swarm-way]");
  if (pad) swarm.drive.keys.add(pad.dataset.swarmWay);
});
for (const type of ["pointerup", "pointercancel"])
  window.addEventListener(type, () => swarm.drive.keys.clear(), true);
