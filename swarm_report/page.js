"use strict";
(() => {
  const root = document.documentElement;
  const theme = () => root.dataset.theme;
  const remembered = () => {
    try { return localStorage.getItem("swarm-report-theme"); } catch { return null; }
  };
  const dark = matchMedia("(prefers-color-scheme: dark)");
  root.dataset.theme = remembered() || (dark.matches ? "dark" : "light");

  document.addEventListener("DOMContentLoaded", () => {
    const button = document.getElementById("theme");
    const name = () => { button.textContent = theme() === "dark" ? "Light" : "Dark"; };
    const show = (wanted) => { root.dataset.theme = wanted; name(); restyle(); };
    name();
    button.onclick = () => {
      show(theme() === "dark" ? "light" : "dark");
      try { localStorage.setItem("swarm-report-theme", theme()); } catch { /* kept for now only */ }
    };
    dark.addEventListener("change", () => { if (!remembered()) show(dark.matches ? "dark" : "light"); });
    document.querySelectorAll("table").forEach(sortable);
    document.querySelectorAll("details.data").forEach(savable);
    document.querySelectorAll("[data-moment]").forEach((link) =>
      link.addEventListener("click", (event) => { event.preventDefault(); goTo(link); }));
    draw();
  });

  // Tables: a click on a heading sorts by it, another one the other way round.
  const value = (cell) => {
    const found = cell.textContent.replace(/[−–]/g, "-").match(/-?\d+(\.\d+)?/);
    return found ? Number(found[0]) : NaN;
  };
  function sortable(table) {
    table.querySelectorAll("thead th").forEach((head, column) => {
      head.title = "Sort by this column";
      head.addEventListener("click", () => {
        const body = table.tBodies[0], down = head.dataset.order === "up";
        table.querySelectorAll("th").forEach((other) => delete other.dataset.order);
        head.dataset.order = down ? "down" : "up";
        const compare = (a, b) => {
          const [left, right] = [a.cells[column], b.cells[column]];
          const numbers = [value(left), value(right)];
          const order = numbers.some(Number.isNaN) || column === 0
            ? left.textContent.localeCompare(right.textContent, "en", { numeric: true })
            : numbers[0] - numbers[1];
          return down ? -order : order;
        };
        body.append(...[...body.rows].sort(compare));
      });
    });
  }

  function savable(details) {
    const button = document.createElement("button");
    button.className = "save";
    button.textContent = "Save as CSV";
    button.onclick = () => {
      const quoted = (cell) => `"${cell.textContent.replaceAll('"', '""')}"`;
      const lines = [...details.querySelectorAll("tr")].map((row) => [...row.cells].map(quoted).join(","));
      const link = document.createElement("a");
      link.href = URL.createObjectURL(new Blob([lines.join("\n") + "\n"], { type: "text/csv" }));
      link.download = `${details.closest("figure").id}.csv`;
      link.click();
    };
    details.append(button);
  }

  // A part of the headline leads to its moment in the bars of the robots, and tells its replay.
  async function goTo(link) {
    const moment = Number(link.dataset.moment), figure = document.getElementById("timeline");
    document.getElementById("replay").textContent = `Watch it: ${link.title}`;
    if (!figure) return;
    figure.scrollIntoView({ block: "center" });
    const place = figure.querySelector(".live");
    for (let tries = 0; tries < 50 && !place.layout; tries += 1)
      await new Promise((done) => setTimeout(done, 100));
    if (!place.layout) return;
    const mark = { type: "line", x0: moment, x1: moment, yref: "paper", y0: 0, y1: 1,
                   line: { color: "#D55E00", width: 2 } };
    await Plotly.relayout(place, { "xaxis.range": [Math.max(0, moment - 30), moment + 90], shapes: [mark] });
  }

  // Plots: plotly.js lies packed in the page; without it, or without this script, the stills stay.
  let ready = null;
  const drawn = new Map();
  const BUTTONS = [["toImage", "zoom2d", "pan2d", "zoomIn2d", "zoomOut2d", "resetScale2d"]];
  async function library() {
    const packed = document.getElementById("plotly-js");
    if (!packed || !window.DecompressionStream) return false;
    const bytes = Uint8Array.from(atob(packed.textContent), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    const script = document.createElement("script");
    script.textContent = await new Response(stream).text();
    document.head.append(script);
    return typeof Plotly !== "undefined";
  }
  function styled(chart, shared) {
    const css = getComputedStyle(root);
    const color = (name) => css.getPropertyValue(name).trim();
    const { data, layout, on_map: onMap } = JSON.parse(
      JSON.stringify(chart).replaceAll('"ink"', JSON.stringify(color("--ink"))));
    // What there is most of stands out from the paper.
    for (const trace of data.filter((one) => one.type === "heatmap"))
      trace.reversescale = theme() === "dark";
    const base = {
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", autosize: true,
      font: { color: color("--ink"), size: 12 }, margin: { l: 60, r: 16, t: 58, b: 48 },
      legend: { bgcolor: "rgba(0,0,0,0)", orientation: "h", y: 1.02, yanchor: "bottom" }, height: 360,
      hoverlabel: { bgcolor: color("--soft"), bordercolor: color("--line"), font: { color: color("--ink") } },
      modebar: { bgcolor: "rgba(0,0,0,0)", color: color("--faint"), activecolor: color("--ink") },
    };
    const merged = { ...base, ...layout };
    for (const key of Object.keys(merged).filter((name) => /^[xy]axis/.test(name)))
      merged[key] = { gridcolor: color("--grid"), linecolor: color("--line"),
                      zerolinecolor: color("--line"), ...merged[key] };
    if (onMap && shared) merged.images = [shared];
    return [data, merged];
  }
  async function draw() {
    const source = document.getElementById("charts");
    if (!source) return;
    const { charts, map } = JSON.parse(source.textContent);
    const watcher = new IntersectionObserver((entries) => {
      for (const entry of entries.filter((one) => one.isIntersecting)) {
        watcher.unobserve(entry.target);
        plot(entry.target, charts[entry.target.id], map);
      }
    }, { rootMargin: "600px" });
    for (const name of Object.keys(charts)) {
      const figure = document.getElementById(name);
      if (figure) watcher.observe(figure);
    }
  }
  async function plot(figure, chart, map) {
    ready ??= library();
    if (!(await ready)) return;
    const place = figure.querySelector(".live");
    figure.classList.add("is-live");
    drawn.set(place, { chart, map });
    const [data, layout] = styled(chart, map);
    await Plotly.newPlot(place, data, layout, { responsive: true, displaylogo: false, modeBarButtons: BUTTONS });
  }
  function restyle() {
    for (const [place, { chart, map }] of drawn) Plotly.react(place, ...styled(chart, map));
  }
})();
