// SPDX-License-Identifier: Apache-2.0

for (const pair of document.querySelectorAll(".pair")) {
  const stage = pair.querySelector(".stage");
  if (!stage) continue;
  const [under, over] = stage.querySelectorAll("img");
  under.src = pair.querySelector(".expected").src;
  over.src = pair.querySelector(".actual").src;
  const slider = pair.querySelector("input");
  slider.oninput = () => {
    stage.style.setProperty("--cut", slider.value + "%");
    over.style.clipPath = "inset(0 0 0 " + slider.value + "%)";
  };
}
