// Puts an interactive plot in the place of every static figure of a report.
//
// Beside each picture the page holds the figure's data as JSON (plots/figure_json.cpp). Where
// anything fails, and in print, the picture stays.

import { PanelPlot, element } from "./panel.js";

const hint =
  "Drag over a plot to zoom, double-click to see all of it; point at a curve for its values; " +
  "click a name to hide it.";

function makeLive(node, index) {
  const figure = JSON.parse(node.querySelector("script.figure-data").textContent);
  const plots = element("div", "plots");
  plots.style.maxWidth = `${figure.columns * figure.panel_width}px`;
  plots.style.setProperty("--columns", figure.columns);
  const panels = figure.panels.map((panel) => {
    const { x } = panel;
    const group = JSON.stringify([index, x.unit, x.logarithmic, x.low, x.high]);
    return new PanelPlot(panel, figure.numbers, figure.panel_height, group);
  });
  for (const plot of panels)
    plot.fellows = panels.filter((other) => other !== plot && other.group === plot.group);
  plots.append(...panels.map((plot) => plot.node));
  node.insertBefore(plots, node.querySelector("figcaption"));
  node.classList.add("live"); // before the start: a hidden panel has no width
  try {
    for (const plot of panels) plot.start();
  } catch (error) {
    node.classList.remove("live");
    plots.remove();
    throw error;
  }
  plots.after(element("p", "hint", hint));
}

document.querySelectorAll("figure.interactive").forEach((node, index) => {
  try {
    makeLive(node, index);
  } catch (error) {
    console.error("figure", index + 1, "stays a picture:", error);
  }
});
