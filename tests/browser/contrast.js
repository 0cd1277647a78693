// Returns the texts whose contrast with what lies behind them is below 4.5 (WCAG 2.1, 1.4.3); single
// signs beside a word are left out.
const light = ([r, g, b]) => [[r, 0.2126], [g, 0.7152], [b, 0.0722]].reduce((sum, [value, part]) => {
  const share = value / 255;
  return sum + part * (share <= 0.03928 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4);
}, 0);
const parse = (text) => (text.match(/[\d.]+/g) || []).map(Number);
const over = (top, below) => [0, 1, 2].map((i) => top[i] * (top[3] ?? 1) + below[i] * (1 - (top[3] ?? 1)));
const found = [];
for (const element of document.querySelectorAll("body *")) {
  const text = [...element.childNodes].filter((node) => node.nodeType === 3)
    .map((node) => node.textContent.trim()).join("");
  const isSeen = element.checkVisibility({ checkOpacity: true, checkVisibilityCSS: true });
  if (!/[a-z]{2}/i.test(text) || !isSeen) continue;
  if (element.closest(":disabled, script, style, #swarm-notice")) continue;
  let opacity = 1;
  const layers = [];
  for (let up = element; up; up = up.parentElement) {
    const style = getComputedStyle(up), color = parse(style.backgroundColor);
    opacity *= Number(style.opacity);
    if (color.length && color[3] !== 0) layers.unshift(color);
  }
  const back = layers.reduce((below, top) => over(top, below), [255, 255, 255]);
  const ink = parse(getComputedStyle(element).color);
  const fore = over([...ink.slice(0, 3), (ink[3] ?? 1) * opacity], back);
  const [high, low] = [light(fore), light(back)].sort((a, b) => b - a);
  if ((high + 0.05) / (low + 0.05) < 4.5) found.push(`${((high + 0.05) / (low + 0.05)).toFixed(2)} ${text}`);
}
return found;
