// Playback of a run seen from above. Reads the page's embedded data (whole centimetres and centiradians), draws on a
// canvas, keeps one cursor in all plots. No network, no storage, no library.
"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const byId = (id) => document.getElementById(id);
  const [scene, strip, slider] = [byId("scene"), byId("strip"), byId("time")];
  const frames = data.frames;
  if (frames.length === 0) {
    byId("playback").innerHTML = '<p class="hint">The record holds no safe commands, so there is nothing to play back.</p>';
    return;
  }
  if (!data.has_zero_level) byId("zero_hint").remove();

  const TRAIL_S = 2.5;
  const PERSON_FIELDS = 6; // track, x, y, radius, vx, vy
  const RUNG_COLORS = ["green", "orange", "red", "purple", "ink"];
  const duration = Math.max(data.duration_s, 1e-3);
  for (const frame of frames) {
    frame.index = new Map();
    for (let at = 0; at < frame.people.length; at += PERSON_FIELDS) frame.index.set(frame.people[at], at);
  }

  // ---- State ----------------------------------------------------------------------------------------------------
  let time = 0;
  let playing = false;
  let colors = {};
  const view = { x: 0, y: 0, scale: 1 }; // centre in metres, pixels per metre

  const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
  const mix = (from, to, share) => from + (to - from) * share;

  // ---- What was at a time ---------------------------------------------------------------------------------------
  const frameBefore = (when) => {
    let [low, high] = [0, frames.length - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (frames[middle].t <= when) low = middle; else high = middle - 1;
    }
    return low;
  };

  const robotAt = (frame, next, share) => {
    const turn = ((next.robot[2] - frame.robot[2] + 3 * 314.159265) % 628.31853) - 314.159265;
    return {
      x: mix(frame.robot[0], next.robot[0], share) / 100,
      y: mix(frame.robot[1], next.robot[1], share) / 100,
      heading: (frame.robot[2] + turn * share) / 100,
    };
  };

  const peopleAt = (frame, next, share) => [...frame.index].map(([track, at]) => {
    const [here, there] = [frame.people, next.people];
    const later = next.index.get(track);
    const moved = (offset) => (later === undefined ? here[at + offset] : mix(here[at + offset], there[later + offset], share)) / 100;
    return { track, x: moved(1), y: moved(2), radius: here[at + 3] / 100, vx: here[at + 4] / 100, vy: here[at + 5] / 100 };
  });

  // ---- Drawing --------------------------------------------------------------------------------------------------
  const readColors = () => {
    const style = getComputedStyle(document.documentElement);
    for (const name of ["ink", "faint", "grid", "blue", "orange", "green", "red", "purple", "grey", "paper"]) {
      colors[name] = style.getPropertyValue(`--${name}`).trim();
    }
  };

  const sized = (canvas) => {
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    return { pen, width, height };
  };

  const drawGrid = (pen, width, height, at) => {
    const [west, east] = [view.x - width / 2 / view.scale, view.x + width / 2 / view.scale];
    const [south, north] = [view.y - height / 2 / view.scale, view.y + height / 2 / view.scale];
    if (view.scale < 6) return;
    pen.beginPath();
    for (let x = Math.ceil(west); x <= east; x += 1) { pen.moveTo(at(x, 0)[0], 0); pen.lineTo(at(x, 0)[0], height); }
    for (let y = Math.ceil(south); y <= north; y += 1) { pen.moveTo(0, at(0, y)[1]); pen.lineTo(width, at(0, y)[1]); }
    pen.strokeStyle = colors.grid;
    pen.lineWidth = 1;
    pen.stroke();
  };

  // The set h < 0 as a tint, its boundary h = 0 as a line; the border of the grid it was found on is no boundary.
  const drawZeroLevel = (pen, frame, at) => {
    if (frame.zero.length === 0) return;
    const [[west, south], [east, north]] = frame.grid;
    const borders = (from, to, low, high) => Math.abs(from - to) <= 1 && (Math.abs(from - low) <= 1 || Math.abs(from - high) <= 1);
    const [fill, line] = [new Path2D(), new Path2D()];
    for (const ring of frame.zero) {
      let [x, y] = [0, 0];
      for (let step = 0; step < ring.length; step += 2) {
        const [fromX, fromY] = [x, y];
        [x, y] = [x + ring[step], y + ring[step + 1]];
        const point = at(x / 100, y / 100);
        if (step === 0) { fill.moveTo(...point); line.moveTo(...point); continue; }
        fill.lineTo(...point);
        if (borders(fromX, x, west, east) || borders(fromY, y, south, north)) line.moveTo(...point); else line.lineTo(...point);
      }
      fill.closePath();
    }
    pen.globalAlpha = 0.1;
    pen.fillStyle = colors.red;
    pen.fill(fill, "evenodd");
    pen.globalAlpha = 1;
    pen.strokeStyle = colors.red;
    pen.lineWidth = 2;
    pen.stroke(line);
  };

  const drawGoal = (pen, at) => {
    const goals = data.goals.filter((goal) => goal[0] <= time);
    const goal = goals[goals.length - 1] || data.goals[0];
    if (!goal) return;
    const [x, y] = at(goal[1] / 100, goal[2] / 100);
    const reach = Math.max(0.3 * view.scale, 6);
    pen.beginPath();
    pen.arc(x, y, reach * 0.66, 0, 2 * Math.PI);
    pen.moveTo(x - reach, y); pen.lineTo(x + reach, y);
    pen.moveTo(x, y - reach); pen.lineTo(x, y + reach);
    pen.strokeStyle = colors.green;
    pen.lineWidth = 2.5;
    pen.stroke();
  };

  const drawRobotTrail = (pen, last, robot, at) => {
    pen.beginPath();
    for (let index = 0; index <= last; index += 1) pen.lineTo(...at(frames[index].robot[0] / 100, frames[index].robot[1] / 100));
    pen.lineTo(...at(robot.x, robot.y));
    pen.strokeStyle = colors.blue;
    pen.globalAlpha = 0.6;
    pen.lineWidth = 2.5;
    pen.stroke();
    pen.globalAlpha = 1;
  };

  const drawPerson = (pen, person, critical, last, at) => {
    const color = person.track === critical ? colors.red : colors.grey;
    const [x, y] = at(person.x, person.y);
    pen.strokeStyle = color;
    pen.fillStyle = color;
    pen.lineWidth = 1.5;
    pen.globalAlpha = 0.45;
    pen.beginPath();
    for (let index = last; index >= 0 && frames[index].t > time - TRAIL_S; index -= 1) {
      const offset = frames[index].index.get(person.track);
      if (offset === undefined) break;
      if (index === last) pen.moveTo(x, y);
      pen.lineTo(...at(frames[index].people[offset + 1] / 100, frames[index].people[offset + 2] / 100));
    }
    pen.stroke();
    pen.globalAlpha = 0.5;
    pen.beginPath();
    pen.arc(x, y, Math.max(person.radius * view.scale, 2), 0, 2 * Math.PI);
    pen.fill();
    pen.globalAlpha = 1;
    pen.stroke();
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(...at(person.x + person.vx, person.y + person.vy));
    pen.lineWidth = 2.5;
    pen.stroke();
    if (view.scale > 28) {
      pen.fillStyle = colors.ink;
      pen.font = "11px system-ui, sans-serif";
      pen.textAlign = "center";
      pen.fillText(person.track, x, y - person.radius * view.scale - 4);
    }
  };

  const drawRobot = (pen, robot, rung, at) => {
    const [x, y] = at(robot.x, robot.y);
    const radius = Math.max(data.robot_radius_m * view.scale, 4);
    pen.beginPath();
    pen.arc(x, y, radius, 0, 2 * Math.PI);
    pen.fillStyle = colors.blue;
    pen.fill();
    pen.strokeStyle = colors[RUNG_COLORS[rung]];
    pen.lineWidth = 5;
    pen.stroke();
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(x + radius * Math.cos(robot.heading), y - radius * Math.sin(robot.heading));
    pen.strokeStyle = colors.paper;
    pen.lineWidth = 3;
    pen.stroke();
  };

  const drawScene = (frame, next, share, last) => {
    const { pen, width, height } = sized(scene);
    const at = (x, y) => [width / 2 + (x - view.x) * view.scale, height / 2 - (y - view.y) * view.scale];
    pen.clearRect(0, 0, width, height);
    pen.lineJoin = "round";
    drawGrid(pen, width, height, at);
    drawZeroLevel(pen, frame, at);
    drawGoal(pen, at);
    const robot = robotAt(frame, next, share);
    drawRobotTrail(pen, last, robot, at);
    for (const person of peopleAt(frame, next, share)) drawPerson(pen, person, frame.critical, last, at);
    drawRobot(pen, robot, frame.rung, at);
  };

  const drawStrip = () => {
    const { pen, width, height } = sized(strip);
    for (const [rung, start, end] of data.strip) {
      pen.fillStyle = colors[RUNG_COLORS[rung]];
      pen.fillRect((start / duration) * width, 0, Math.max(((end - start) / duration) * width, 1), height);
    }
  };

  // ---- Figures at the cursor ------------------------------------------------------------------------------------
  const show = (value, unit, absent = "–") => (value === null ? absent : `${value.toFixed(3)} ${unit}`);

  const writeValues = (frame) => {
    const hasBarrier = frame.rung < 2;
    const far = hasBarrier ? "no obstacle" : "not evaluated";
    const rows = [
      ["h", show(frame.h, "m", far)],
      ["SDF", show(frame.sdf, "m", far)],
      ["Slack", show(frame.slack, "m/s")],
      ["Hard margin", show(frame.margin, "m/s", far)],
    ];
    data.components.forEach(([name, unit], index) => {
      rows.push([`${name}, wanted`, show(frame.wanted[index], unit)], [`${name}, sent`, show(frame.u[index], unit)]);
    });
    rows.push(["Obstacles seen", String(frame.index.size)], ["Weighs most", frame.critical === 0 ? "none" : `track ${frame.critical}`]);
    const list = byId("values");
    list.replaceChildren();
    const rung = document.createElement("dd");
    rung.className = "rung";
    rung.style.borderColor = colors[RUNG_COLORS[frame.rung]];
    rung.textContent = data.rungs[frame.rung];
    const why = document.createElement("small");
    why.textContent = frame.why === "none" ? "nothing is wrong" : frame.why.replaceAll("_", " ");
    rung.append(why);
    list.append(rung);
    for (const [name, value] of rows) {
      const [term, description] = [document.createElement("dt"), document.createElement("dd")];
      term.textContent = name;
      description.textContent = value;
      list.append(term, description);
    }
  };

  // ---- Cursors in the plots -------------------------------------------------------------------------------------
  const plots = [...document.querySelectorAll("svg.plot[data-left]")].map((svg) => {
    const [left, right, end] = ["left", "right", "end"].map((name) => Number(svg.dataset[name]));
    const box = svg.viewBox.baseVal;
    const line = document.createElementNS("http://www.w3.org/2000/svg", "line");
    line.setAttribute("class", "cursor");
    line.setAttribute("y1", 0);
    line.setAttribute("y2", box.height);
    svg.append(line);
    svg.addEventListener("click", (event) => {
      const bounds = svg.getBoundingClientRect();
      const x = ((event.clientX - bounds.left) / bounds.width) * box.width;
      seek(((x - left) / (right - left)) * end);
    });
    return (when) => {
      const x = left + (when / end) * (right - left);
      line.setAttribute("x1", x);
      line.setAttribute("x2", x);
    };
  });

  const update = () => {
    const last = frameBefore(time);
    const [frame, next] = [frames[last], frames[Math.min(last + 1, frames.length - 1)]];
    const share = next === frame ? 0 : clamp((time - frame.t) / (next.t - frame.t), 0, 1);
    drawScene(frame, next, share, last);
    writeValues(frame);
    plots.forEach((move) => move(time));
    slider.value = time;
    byId("clock").value = `${time.toFixed(2)} / ${duration.toFixed(2)} s`;
  };

  const seek = (when) => { time = clamp(when, 0, duration); update(); };

  // ---- Playing --------------------------------------------------------------------------------------------------
  let lastTick = 0;
  const tick = (now) => {
    if (!playing) return;
    const speed = Number(byId("speed").value);
    seek(time + ((now - lastTick) / 1000) * speed);
    lastTick = now;
    if (time >= duration) setPlaying(false); else requestAnimationFrame(tick);
  };
  const setPlaying = (on) => {
    playing = on;
    byId("play").textContent = on ? "Pause" : "Play";
    if (!on) return;
    if (time >= duration) time = 0;
    lastTick = performance.now();
    requestAnimationFrame(tick);
  };

  // ---- View -----------------------------------------------------------------------------------------------------
  const fit = () => {
    const [[west, south], [east, north]] = data.scene_m;
    const aspect = (north - south) / (east - west);
    scene.style.height = `${clamp(scene.clientWidth * aspect, 340, 0.68 * window.innerHeight)}px`;
    view.x = (west + east) / 2;
    view.y = (south + north) / 2;
    view.scale = Math.min(scene.clientWidth / (east - west), scene.clientHeight / (north - south));
    update();
  };

  scene.addEventListener("wheel", (event) => {
    event.preventDefault();
    const factor = Math.exp(-event.deltaY * 0.0015);
    const [dx, dy] = [event.offsetX - scene.clientWidth / 2, scene.clientHeight / 2 - event.offsetY];
    const scale = clamp(view.scale * factor, 2, 600);
    view.x += dx / view.scale - dx / scale;
    view.y += dy / view.scale - dy / scale;
    view.scale = scale;
    update();
  }, { passive: false });
  scene.addEventListener("pointerdown", (event) => scene.setPointerCapture(event.pointerId));
  scene.addEventListener("pointermove", (event) => {
    if (!scene.hasPointerCapture(event.pointerId)) return;
    view.x -= event.movementX / view.scale;
    view.y += event.movementY / view.scale;
    update();
  });
  scene.addEventListener("dblclick", fit);

  const lowestTime = () => {
    let lowest = null;
    for (const frame of frames) if (frame.h !== null && (lowest === null || frame.h < lowest.h)) lowest = frame;
    return lowest === null ? 0 : lowest.t;
  };

  byId("play").addEventListener("click", () => setPlaying(!playing));
  byId("lowest").addEventListener("click", () => seek(lowestTime()));
  byId("fit").addEventListener("click", fit);
  slider.max = duration;
  slider.addEventListener("input", () => seek(Number(slider.value)));
  document.addEventListener("keydown", (event) => {
    if (event.target instanceof HTMLSelectElement || event.target instanceof HTMLButtonElement || event.ctrlKey || event.metaKey) return;
    const step = event.shiftKey ? 1 : 0.05;
    if (event.key === " ") setPlaying(!playing);
    else if (event.key === "ArrowRight") seek(time + step);
    else if (event.key === "ArrowLeft") seek(time - step);
    else if (event.key === "Home") seek(0);
    else if (event.key === "End") seek(duration);
    else return;
    event.preventDefault();
  });
  const redraw = () => { readColors(); drawStrip(); update(); };
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  window.addEventListener("resize", () => { fit(); drawStrip(); });

  // `#t=12.5` opens the page at that time; otherwise it opens where h was smallest.
  const asked = Number.parseFloat(new URLSearchParams(location.hash.slice(1)).get("t"));
  readColors();
  time = Number.isFinite(asked) ? clamp(asked, 0, duration) : lowestTime();
  fit();
  drawStrip();
})();
