// A fleet control with the library vda-5050-lib, unmodified: orders, updates and cancels of 2.0.
// NODE_PATH=... node lib_master.js PORT ROBOTS ORDERS MAP HALF
const { MasterController } = require("vda-5050-lib");

const [port, robots, orders, mapId, half] = process.argv.slice(2);
const PITCH = 1.8; // [m] between the places to go to
const PATIENCE = 20000; // [ms] after which an order that nobody answers is sent anew
const KINDS = ["plain", "update", "plain", "cancel", "work"];
const count = Math.floor((2 * half) / PITCH) + 1;
const places = [];
for (let i = 0; i < count; i++) for (let j = 0; j < count; j++) places.push([PITCH * i - half, PITCH * j - half]);
const targets = {};
const states = {};
const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
const master = new MasterController(
    { interfaceName: "uagv", transport: { brokerUrl: `mqtt://127.0.0.1:${port}` }, vdaVersion: "2.0.0" }, {});

const action = (actionType, blockingType, parameters) => ({
    actionType, blockingType, actionId: master.createUuid(),
    actionParameters: Object.entries(parameters).map(([key, value]) => ({ key, value })),
});

function way(here, end, kind) {
    const at = [here, [(here[0] + end[0]) / 2, (here[1] + end[1]) / 2], end];
    const isReleased = (i) => i < 2 || kind !== "update";
    const nodes = at.map(([x, y], i) => ({
        nodeId: `n${i}`, sequenceId: 2 * i, released: isReleased(i), nodePosition: { x, y, mapId }, actions: [],
    }));
    const edges = [0, 1].map((i) => ({
        edgeId: `e${i}`, sequenceId: 2 * i + 1, released: isReleased(i + 1), actions: [],
        startNodeId: `n${i}`, endNodeId: `n${i + 1}`,
    }));
    if (kind === "work") nodes[2].actions.push(action("wait", "HARD", { duration: 1.0 }));
    return { nodes, edges };
}

function choose(name, number) {
    const taken = Object.entries(targets).filter(([other]) => other !== name).map(([, place]) => String(place));
    const first = 7 * number + 11 * Number(name.slice(6));
    const around = places.map((_, k) => places[(first + k) % places.length]);
    targets[name] = around.find((place) => !taken.includes(String(place)));
    return targets[name];
}

async function carryOut(name, number) {
    const agv = { manufacturer: "swarm", serialNumber: name };
    const kind = KINDS[number % KINDS.length], orderId = master.createUuid();
    const { x, y } = states[name].agvPosition;
    const { nodes, edges } = way([x, y], choose(name, number), kind);
    let settle;
    const settled = new Promise((resolve) => { settle = resolve; });
    const handler = {
        onOrderProcessed: (error, byCancelation, active) => { if (error || !active) settle(error); },
    };
    await master.assignOrder(agv, { orderId, orderUpdateId: 0, nodes, edges }, handler);
    for (const end = Date.now() + PATIENCE; states[name].orderId !== orderId; await sleep(20)) {
        const refs = states[name].errors.flatMap((e) => e.errorReferences || []);
        if (refs.some((r) => r.referenceValue === orderId) || Date.now() > end) return false;
    }
    if (kind === "update") {
        const last = { ...nodes[2], released: true }, edge = { ...edges[1], released: true };
        await master.assignOrder(agv, { orderId, orderUpdateId: 1, nodes: [nodes[1], last], edges: [edge] }, handler);
    }
    if (kind === "cancel") {
        await master.initiateInstantActions(agv, { instantActions: [action("cancelOrder", "NONE", {})] },
            { onActionStateChanged: () => {}, onActionError: () => {} });
    }
    const isOver = (state) => state.orderId === orderId && !state.nodeStates.length
        && state.actionStates.every((each) => ["FINISHED", "FAILED"].includes(each.actionStatus));
    for (let turn = 0; !isOver(states[name]); turn++) {
        await Promise.race([settled, sleep(100)]);
        const isForgotten = kind === "update" && states[name].nodeStates.some((each) => !each.released);
        if (isForgotten && turn % 200 === 199) return false; // its update was lost
    }
    return true;
}

async function work(name) {
    const agv = { manufacturer: "swarm", serialNumber: name };
    while (!states[name]) {
        await master.initiateInstantActions(agv, { instantActions: [action("stateRequest", "NONE", {})] },
            { onActionStateChanged: () => {}, onActionError: () => {} });
        await sleep(2000);
    }
    for (let number = 0; number < Number(orders); number++) while (!(await carryOut(name, number)));
}

(async () => {
    await master.start();
    await master.subscribe("state", { manufacturer: "swarm" }, (state) => { states[state.serialNumber] = state; });
    await Promise.all(Array.from({ length: Number(robots) }, (_, i) => work(`Srobot${i + 1}`)));
    await master.stop();
    process.exit(0);
})().catch((error) => { process.stderr.write(`${error.stack || error}\n`); process.exit(1); });
