// The picture of a camera of the robot, in a corner of the 3D view of the drive page.
// Pictures come by a websocket of their own, which is open only while one is looked at.
"use strict";

const SHOWN = "teleopctl.drive.camera";
const CAMERA_RETRY_MS = 1000;
let cameras = [];
// Topic that is shown; empty while the picture is hidden.
let chosen = "";
let pictures = null;
let pictureAddress = "";

// What was chosen is kept in the browser: a topic, or nothing for a hidden picture. On a small screen
// it is hidden at first.
function remembered() {
  try {
    return localStorage.getItem(SHOWN);
  } catch {
    return null;
  }
}

function remember(topic) {
  try {
    localStorage.setItem(SHOWN, topic);
  } catch {
    // The choice lasts as long as the page.
  }
}

let wanted = remembered() ?? (window.innerWidth > 820 ? null : "");

window.showCameras = (found) => {
  if (found.join() === cameras.join()) return;
  cameras = found;
  choose();
};

// Shows the wanted camera, or the first one if there was no choice or it has gone.
function choose() {
  const topic = wanted === "" || !cameras.length ? "" : cameras.includes(wanted) ? wanted : cameras[0];
  element("camera").hidden = !topic;
  element("camera_show").hidden = Boolean(topic) || !cameras.length;
  element("camera_next").hidden = cameras.length < 2;
  if (topic !== chosen) {
    chosen = topic;
    element("camera_picture").removeAttribute("src");
    element("camera_name").textContent = element("camera_name").title = topic;
    element("camera_picture").alt = topic ? `Picture of the camera ${topic}` : "";
  }
  receive();
}

// Opens or closes the websocket of the pictures, as one is looked at or not.
function receive() {
  const topic = document.hidden ? "" : chosen;
  if (pictures && pictures.topic === topic && pictures.readyState <= WebSocket.OPEN) return;
  if (pictures) {
    pictures.onclose = pictures.onmessage = null;
    pictures.close();
    pictures = null;
  }
  if (!topic) return;
  const scheme = location.protocol === "https:" ? "wss" : "ws";
  pictures = new WebSocket(`${scheme}://${location.host}/drive/camera?topic=${encodeURIComponent(topic)}`);
  pictures.topic = topic;
  pictures.binaryType = "blob";
  pictures.onmessage = (event) => {
    const before = pictureAddress;
    pictureAddress = URL.createObjectURL(event.data);
    element("camera_picture").src = pictureAddress;
    if (before) URL.revokeObjectURL(before);
  };
  pictures.onclose = () => setTimeout(receive, CAMERA_RETRY_MS);
}

function want(topic, button) {
  wanted = topic;
  remember(topic);
  choose();
  button.blur();
}

element("camera_show").addEventListener("click", () => want(cameras[0] || "", element("camera_show")));
element("camera_hide").addEventListener("click", () => want("", element("camera_hide")));
element("camera_next").addEventListener("click", () => {
  want(cameras[(cameras.indexOf(chosen) + 1) % cameras.length], element("camera_next"));
});
document.addEventListener("visibilitychange", receive);
