// The drive page: reads keys, touch pads and gamepads, and sends their state to the device node.
// Messages of the websocket are documented in docs/drive.md.
"use strict";

const PERIOD_MS = 20;
const IDLE_MS = 500;
const RECONNECT_MS = 1000;
const element = (id) => document.getElementById(id);

// --- hands ---------------------------------------------------------------------------------------

const keys = new Set();
const pads = { left_x: 0, left_y: 0, right_x: 0, right_y: 0, tilt_x: 0, tilt_y: 0 };
// The right pad lifts and turns, or tilts.
let tilts = false;
const pointers = new Map();
let sequence = 0;
let lastSent = 0;
let wasHeld = false;
// Whether a mouse button or a finger is held in the 3D view: the gripper follows its handle only then.
let drags = false;
let state = {};

const WANTED = new Set(
  [...document.querySelectorAll("kbd[data-key]")].map((shown) => shown.dataset.key));

function onKey(event) {
  if (event.ctrlKey || event.altKey || event.metaKey || !WANTED.has(event.code)) return;
  // The 3D view, whose keys move the camera, does not get them.
  event.preventDefault();
  event.stopImmediatePropagation();
  if (event.repeat) return;
  if (event.type === "keydown") keys.add(event.code);
  else keys.delete(event.code);
  showKeys();
  sendHands();
}

function showKeys() {
  for (const shown of document.querySelectorAll("kbd[data-key]")) {
    shown.classList.toggle("held", keys.has(shown.dataset.key));
  }
}

// What is not seen to be released counts as released.
function releaseAll() {
  keys.clear();
  pointers.clear();
  drags = false;
  for (const name of ["left", "right"]) movePad(name, 0, 0, false);
  showKeys();
  sendHands();
}

function listenTo(view) {
  view.addEventListener("keydown", onKey, true);
  view.addEventListener("keyup", onKey, true);
}

listenTo(window);
window.addEventListener("blur", () => {
  // A click into the 3D view takes the focus, not the hand.
  setTimeout(() => document.hasFocus() || releaseAll(), 0);
});
window.addEventListener("pagehide", releaseAll);
document.addEventListener("visibilitychange", () => document.hidden && releaseAll());
element("view").addEventListener("load", () => {
  const view = element("view").contentWindow;
  listenTo(view);
  showSceneAlone(view.document);
  const hold = (held) => () => {
    drags = held;
    sendHands();
  };
  view.addEventListener("pointerdown", hold(true), true);
  view.addEventListener("pointerup", hold(false), true);
  view.addEventListener("pointercancel", hold(false), true);
  view.addEventListener("blur", () => setTimeout(() => document.hasFocus() || releaseAll(), 0));
});

// Hides the panels of the 3D page: here is room for the scene alone. Siblings of the elements that
// contain the canvas are hidden, also those that are added later.
function showSceneAlone(inner) {
  const canvas = inner.querySelector("canvas");
  if (!canvas) {
    setTimeout(() => showSceneAlone(inner), 100);
    return;
  }
  const style = inner.createElement("style");
  // Docked panels have left the scene the room between them.
  style.textContent = "[data-drive=around] > :not([data-drive]) { display: none !important; } "
    + "[data-drive=scene] { inset: 0 !important; }";
  inner.head.append(style);
  let shown = canvas.parentElement;
  shown.dataset.drive = "scene";
  while (shown !== inner.body) {
    shown = shown.parentElement;
    shown.dataset.drive = "around";
  }
}

function movePad(name, x, y, held) {
  const axes = name === "right" && tilts ? "tilt" : name;
  pads[`${axes}_x`] = x;
  pads[`${axes}_y`] = y;
  const pad = element(name);
  pad.classList.toggle("held", held);
  pad.querySelector("i").style.transform = `translate(${x * 97}%, ${-y * 97}%)`;
}

for (const name of ["left", "right"]) {
  const pad = element(name);
  const follow = (event) => {
    const box = pad.getBoundingClientRect();
    const clip = (value) => Math.max(-1, Math.min(1, value));
    // The edge of the pad is reached a little before the finger leaves it.
    const x = clip(((event.clientX - box.left) / box.width - 0.5) * 2.4);
    const y = clip((0.5 - (event.clientY - box.top) / box.height) * 2.4);
    movePad(name, x, y, true);
  };
  pad.addEventListener("pointerdown", (event) => {
    event.preventDefault();
    pad.setPointerCapture(event.pointerId);
    pointers.set(name, event.pointerId);
    follow(event);
    sendHands();
  });
  pad.addEventListener("pointermove", (event) => {
    if (pointers.get(name) === event.pointerId) follow(event);
  });
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
    pad.addEventListener(end, (event) => {
      if (pointers.get(name) !== event.pointerId) return;
      pointers.delete(name);
      movePad(name, 0, 0, false);
      sendHands();
    });
  }
}

function choosePad(isTilt) {
  pointers.delete("right");
  movePad("right", 0, 0, false);
  tilts = isTilt;
  document.body.classList.toggle("tilting", tilts);
  element("pad_lift").setAttribute("aria-pressed", String(!tilts));
  element("pad_tilt").setAttribute("aria-pressed", String(tilts));
  sendHands();
}

element("pad_lift").addEventListener("click", () => choosePad(false));
element("pad_tilt").addEventListener("click", () => choosePad(true));

function gamepads() {
  if (!navigator.getGamepads) return [];
  return [...navigator.getGamepads()].filter((pad) => pad && pad.connected).map((pad) => ({
    id: pad.id,
    mapping: pad.mapping,
    axes: pad.axes.map((value) => Math.round(value * 1000) / 1000),
    buttons: pad.buttons.map((button) => (button.pressed ? Math.max(button.value, 0.51) : button.value)),
  }));
}

// --- connection ----------------------------------------------------------------------------------

let socket = null;

function connect() {
  const scheme = location.protocol === "https:" ? "wss" : "ws";
  socket = new WebSocket(`${scheme}://${location.host}/drive/socket`);
  socket.onopen = sendHands;
  socket.onmessage = (event) => {
    const message = JSON.parse(event.data);
    if (message.type === "state") show(message);
    else if (message.type === "problem") showStatus(message.text, true);
  };
  socket.onclose = () => {
    releaseAll();
    element("robot").textContent = "Not connected";
    element("who").textContent = element("now").textContent = "";
    showStatus("The connection is lost; nothing moves. Trying again …", true);
    setTimeout(connect, RECONNECT_MS);
  };
}

function send(message) {
  if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
}

function sendHands() {
  lastSent = performance.now();
  const pressed = document.hidden ? [] : gamepads();
  sequence += 1;
  send({ type: "hands", sequence, keys: [...keys], pads, drags, gamepads: pressed });
  const isUsed = (pad) =>
    pad.buttons.some((value) => value > 0.1) || pad.axes.some((value) => Math.abs(value) > 0.1);
  wasHeld = drags || keys.size > 0 || pointers.size > 0 || pressed.some(isUsed);
}

setInterval(() => {
  const now = performance.now();
  const anyGamepad = gamepads().length > 0;
  if (!document.hidden && (wasHeld || anyGamepad || now - lastSent > IDLE_MS)) sendHands();
}, PERIOD_MS);

// --- buttons -------------------------------------------------------------------------------------

element("stop").addEventListener("click", () => {
  releaseAll();
  send({ type: "press", action: (state.stopped_by || []).length ? "release_stop" : "stop" });
  element("stop").blur();
});
element("take").addEventListener("click", () => {
  send({ type: "press", action: "take" });
  element("take").blur();
});

const slider = element("gripper");
let sliderHeld = false;
slider.addEventListener("pointerdown", () => { sliderHeld = true; });
for (const end of ["pointerup", "pointercancel"]) {
  slider.addEventListener(end, () => { sliderHeld = false; slider.blur(); });
}
let sliderTimer = 0;
slider.addEventListener("input", () => {
  if (sliderTimer) return;
  sliderTimer = setTimeout(() => {
    sliderTimer = 0;
    send({ type: "gripper", opening: slider.value / 100 });
  }, 50);
});

// --- what is shown -------------------------------------------------------------------------------

// Shows a sentence, and in the line below it servo's own text for it.
function showStatus(text, warn, exact) {
  const status = element("status");
  // A screen reader reads what is written here, so the same text is not written again.
  if (status.textContent !== text) status.textContent = text;
  status.title = exact || text;
  status.classList.toggle("warn", Boolean(warn));
}

const DIRECTIONS = [
  ["forward", "back"], ["left", "right"], ["up", "down"],
  ["lean right", "lean left"], ["tilt forward", "tilt back"], ["turn left", "turn right"],
];
const GRIPPER_AXES = ["x", "y", "z", "about x", "about y", "about z"];

// Returns what is commanded, in words: "forward, up 50 %".
function commanded(message) {
  const values = [...message.linear, ...message.angular];
  const words = values.map((value, i) => {
    if (!value) return "";
    const name = message.frame === "tip" && message.kind !== "base"
      ? `${value > 0 ? "+" : "−"}${GRIPPER_AXES[i]} of the gripper` : DIRECTIONS[i][value > 0 ? 0 : 1];
    return Math.abs(value) < 0.995 ? `${name} ${Math.round(Math.abs(value) * 100)} %` : name;
  }).filter(Boolean);
  return words.join(", ") || (message.is_moving ? "to the handle" : "nothing held");
}

function whoDrives(message) {
  const holder = message.holder;
  if (!holder) return "not driven";
  if (!holder.is_this) return `${holder.node} drives${holder.device ? `, by ${holder.device}` : ""}`;
  return message.is_other ? "another browser drives" : "you drive";
}

const isTouch = window.matchMedia("(pointer: coarse)").matches;

function hint(isBase) {
  const handle = isBase ? "" : "Drag the handle at the gripper, or ";
  const held = isTouch ? "keep a finger on a pad" : "hold a key, a pad or a gamepad's left shoulder button";
  const text = `${handle}${held}: the robot moves until you let go`;
  return text[0].toUpperCase() + text.slice(1);
}

function show(message) {
  state = message;
  const isBase = message.kind === "base";
  document.body.classList.toggle("of-base", isBase);
  const stoppedBy = message.stopped_by || [];
  document.body.classList.toggle("no-turn", !isBase && message.turns === false);
  document.body.classList.toggle("no-grip", message.has_gripper === false);
  if (tilts && (isBase || message.turns === false)) choosePad(false);
  element("robot").textContent = message.robot ? `Drive ${message.robot}` : "Drive";
  element("who").textContent = `· ${whoDrives(message)}`;
  element("stop").textContent = stoppedBy.length ? "Release robot" : "Stop";
  element("stop").classList.toggle("held", stoppedBy.length > 0);
  element("take").hidden = !message.is_other;
  const isCut = message.is_moving && Boolean(message.words);
  if (stoppedBy.length) showStatus(`The robot is stopped by ${stoppedBy.join(", ")}: press Release robot to go on`, true);
  else if (message.refusal) showStatus(`Not moved: ${message.refusal}`, true);
  else if (isCut) showStatus(message.words, true, message.status);
  else if (message.note) showStatus(message.note, true, message.note_status);
  else if (message.problem) showStatus(message.problem, true);
  else if (message.is_moving) showStatus("Moving", false);
  else if (message.holder && !message.holder.is_this) showStatus(`${whoDrives(message)}: press Take over to drive`, true);
  else showStatus(hint(isBase), false);
  const exact = isCut ? message.status : message.note_status;
  const speed = `${message.speed_m_s.toFixed(2)} m/s, ${message.speed_rad_s.toFixed(2)} rad/s`;
  const now = [commanded(message), speed, exact ? `servo: ${exact}` : ""].filter(Boolean).join(" · ");
  element("now").textContent = element("now").title = now;
  if (message.opening !== null) {
    element("opening").textContent = `${Math.round(message.opening * 100)} %`;
    if (!sliderHeld) {
      const wanted = message.wanted_opening;
      slider.value = 100 * (wanted === null ? message.opening : wanted);
    }
  }
  slider.disabled = message.opening === null;
  element("speed").textContent = speed;
  const row = element("speeds");
  if (row.childElementCount !== message.speeds.length) {
    row.replaceChildren(...message.speeds.map((part) => {
      const button = document.createElement("button");
      button.textContent = `${Math.round(part * 100)} %`;
      return button;
    }));
    [...row.children].forEach((button, step) => {
      button.addEventListener("click", () => {
        const steps = step - state.speed_step;
        for (let i = 0; i < Math.abs(steps); i += 1) {
          send({ type: "press", action: steps > 0 ? "faster" : "slower" });
        }
        button.blur();
      });
    });
  }
  [...row.children].forEach((button, step) => {
    button.setAttribute("aria-pressed", String(step === message.speed_step));
  });
  window.showCameras(message.cameras || []);
  showLeader(message.leader);
  showEpisode(message.episode);
  const note = element("gamepad");
  const count = gamepads().length;
  note.classList.toggle("warn", Boolean(message.gamepad_problem));
  if (message.gamepad_problem) note.textContent = message.gamepad_problem;
  else if (!navigator.getGamepads) note.textContent = "This browser has no gamepad interface; use keys or pads.";
  else if (count) note.textContent = "Gamepad: hold the left shoulder button (LB); the sticks move it, "
    + (isBase ? "" : "the right one (RB) opens the gripper and the trigger below it closes, ") + "B stops. "
    + (message.episode ? "Start records, Y is a success, A saves, Back discards." : "");
  else note.textContent = "Gamepad: switch it on and press a button.";
}

// Button of a leader arm, where a teleop_device follows one.
function showLeader(leader) {
  element("leader").hidden = !leader;
  if (!leader) return;
  element("engage").textContent = leader.is_engaged ? "Disengage" : "Engage";
  element("engage").classList.toggle("held", leader.is_engaged);
  element("leader_note").textContent = leader.problem || (leader.is_engaged ? leader.doing : "");
  element("leader_note").classList.toggle("warn", Boolean(leader.problem));
}

element("engage").addEventListener("click", () => {
  send({ type: "press", action: state.leader && state.leader.is_engaged ? "disengage" : "engage" });
  element("engage").blur();
});

// Buttons of an episode_recorder, where one runs.
function showEpisode(episode) {
  element("episode").hidden = !episode;
  if (!episode) return;
  const recording = episode.state === "recording";
  element("episode_state").textContent = recording
    ? `${episode.episode} is being recorded` : `${episode.saved} saved, ${episode.discarded} discarded`;
  element("episode_note").textContent = episode.failure || episode.note || episode.task;
  element("episode_note").classList.toggle("warn", Boolean(episode.failure));
  for (const button of document.querySelectorAll("#episode button")) {
    button.disabled = (button.dataset.press === "episode_start") === recording;
  }
}

for (const button of document.querySelectorAll("#episode button")) {
  button.addEventListener("click", () => {
    send({ type: "press", action: button.dataset.press });
    button.blur();
  });
}

connect();
