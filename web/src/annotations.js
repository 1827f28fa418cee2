// Reference lines, single points and their texts, drawn over a panel's curves.

import { letters } from "./axes.js";

function inside(u, f) {
  const { ctx, bbox } = u;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  f(ctx, bbox, devicePixelRatio);
  ctx.restore();
}

export function drawReferenceLines(u, panel) {
  inside(u, (ctx, bbox, ratio) => {
    ctx.strokeStyle = "#777777";
    ctx.lineWidth = ratio;
    for (const line of panel.lines) {
      const at = Math.round(u.valToPos(line.value, line.vertical ? "x" : "y", true)) + 0.5 * ratio;
      ctx.beginPath();
      ctx.moveTo(line.vertical ? at : bbox.left, line.vertical ? bbox.top : at);
      ctx.lineTo(line.vertical ? at : bbox.left + bbox.width, line.vertical ? bbox.top + bbox.height : at);
      ctx.stroke();
    }
  });
}

function drawShape(ctx, marker, x, y, ratio) {
  const radius = (marker.shape === "cross" ? 5 : 4.5) * ratio;
  ctx.strokeStyle = ctx.fillStyle = marker.colour;
  ctx.lineWidth = (marker.shape === "cross" ? 3 : 2.5) * ratio;
  ctx.setLineDash([]);
  ctx.beginPath();
  if (marker.shape === "cross") {
    for (const sign of [1, -1]) {
      ctx.moveTo(x - radius, y - sign * radius);
      ctx.lineTo(x + radius, y + sign * radius);
    }
    ctx.stroke();
  } else {
    ctx.arc(x, y, radius, 0, 2 * Math.PI);
    marker.shape === "ring" ? ctx.stroke() : ctx.fill();
  }
}

/** The first place beside the point, that of the picture before others, inside the frame and where
 * no other point or text lies. */
function labelPlace(marker, x, y, width, height, bbox, taken, ratio) {
  const gap = height;
  const places = [
    [x + marker.right * ratio, y + marker.down * ratio],
    [x + gap, y],
    [x - gap - width, y],
    [x + 0.6 * gap, y - 1.2 * gap],
    [x + 0.6 * gap, y + 1.2 * gap],
    [x - 0.6 * gap - width, y - 1.2 * gap],
    [x - 0.6 * gap - width, y + 1.2 * gap],
    [x - 0.5 * width, y - 1.5 * gap],
    [x - 0.5 * width, y + 1.5 * gap],
    [x - 0.5 * width, y - 2.7 * gap],
    [x - 0.5 * width, y + 2.7 * gap],
  ].map(([left, middle]) => ({
    left,
    right: left + width,
    top: middle - 0.5 * height,
    bottom: middle + 0.5 * height,
  }));
  const fits = (box) =>
    box.left >= bbox.left && box.right <= bbox.left + bbox.width &&
    box.top >= bbox.top && box.bottom <= bbox.top + bbox.height;
  const apart = (a, b) =>
    a.right < b.left || b.right < a.left || a.bottom < b.top || b.bottom < a.top;
  return (
    places.find((box) => fits(box) && taken.every((other) => apart(box, other))) ??
    places.find(fits) ??
    places[0]
  );
}

export function drawMarkers(u, panel) {
  inside(u, (ctx, bbox, ratio) => {
    const height = 15 * ratio;
    ctx.font = `${13 * ratio}px ${letters}`;
    ctx.textAlign = "left";
    ctx.textBaseline = "middle";
    ctx.lineJoin = "round";
    const spots = panel.markers.map((marker) => ({
      marker,
      x: u.valToPos(marker.x, "x", true),
      y: u.valToPos(marker.y, "y", true),
    }));
    const radius = 6 * ratio;
    const taken = spots.map(({ x, y }) => ({
      left: x - radius,
      right: x + radius,
      top: y - radius,
      bottom: y + radius,
    }));
    for (const { marker, x, y } of spots) drawShape(ctx, marker, x, y, ratio);
    for (const { marker, x, y } of spots) {
      const seen =
        x >= bbox.left && x <= bbox.left + bbox.width && y >= bbox.top && y <= bbox.top + bbox.height;
      if (!marker.label || !seen) continue;
      const width = ctx.measureText(marker.label).width;
      const box = labelPlace(marker, x, y, width, height, bbox, taken, ratio);
      taken.push(box);
      ctx.strokeStyle = "rgba(255,255,255,0.85)"; // readable where it lies on a curve
      ctx.lineWidth = 4 * ratio;
      ctx.strokeText(marker.label, box.left, 0.5 * (box.top + box.bottom));
      ctx.fillStyle = marker.colour;
      ctx.fillText(marker.label, box.left, 0.5 * (box.top + box.bottom));
    }
  });
}
