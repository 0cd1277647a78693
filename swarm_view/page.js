// What our page does beside viser's client. `swarm.send(kind, value)` brings something to Python,
// as a change of a hidden text field (swarm_view/inbox.py) by viser's own message.
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
  for (const [kind, value] of swarm.waiting.splice(0)) swarm.send(kind, value);
  swarm.tellSize();
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

// react-three-fiber makes it passive; viser's client prevents its default when a drag begins.
const listen = EventTarget.prototype.addEventListener;
EventTarget.prototype.addEventListener = function (type, listener, options) {
  if (type === "pointerdown" && options && options.passive)
    options = { ...options, passive: false };
  return listen.call(this, type, listener, options);
};

document.title =
  "swarm" + (new URLSearchParams(location.search).get("robot") ?? "").replace(/^(.)/, " · $1");
