// The recordings of the flight recorder: what there is, how it is taken away, and one of now.

import { element, number, say } from "./words.js";

/** All recordings that there are, the newest first; `folder` is null where nothing is recorded. */
export async function recordings() {
  const answer = await fetch("/api/recordings");
  return answer.ok ? answer.json() : { folder: null, recordings: [] };
}

/** Where a recording is had, and how it is replayed. */
export function recording({ name, bytes }) {
  return element("span", {},
    element("a", { href: `/api/recordings/${name}.tar`, download: true }, `${name}.tar`),
    element("span", { class: "quiet" }, ` ${number(bytes / 1e6, 1)} MB; `),
    element("code", {}, `tar -xf ${name}.tar && tertius replay ${name}`));
}

/** The recording of an incident of the store, if it is among `all`. */
export function recordingOf(incident, all) {
  const time = new Date(incident.begin_s * 1000).toISOString().slice(0, 19).replaceAll(/[-:]/g, "");
  const of = incident.cylinder == null ? "machine" : `cylinder-${incident.cylinder}`;
  const start = `${time}Z-${of}-incident-${incident.number}`;
  return all.find(({ name }) => name === start || name.startsWith(`${start}-`));
}

/** The list of recordings, with a button for one of now. */
export class Recordings {
  constructor() {
    this.list = element("ul");
    this.note = element("p", { role: "status" });
    this.button = element("button", { type: "button" }, "Record the last seconds now");
    this.token = element("input", { type: "password", autocomplete: "off", value: sessionStorage.getItem("token") ?? "" });
    this.button.addEventListener("click", () => this.record());
    this.node = element("section", { "aria-label": "Recordings" }, element("h2", {}, "Recordings"), this.note, this.list,
      element("p", { class: "buttons" }, element("label", {}, "Token", this.token), this.button));
  }

  async refresh() {
    const { folder, recordings: all } = await recordings();
    this.button.parentElement.hidden = folder === null;
    say(this.note, folder === null ? "Nothing is recorded: [recorder] of the configuration has no folder."
      : all.length === 0 ? "There is none yet." : "");
    this.list.replaceChildren(...all.map((it) => element("li", {}, recording(it))));
  }

  async record() {
    sessionStorage.setItem("token", this.token.value);
    const answer = await fetch("/api/record", {
      method: "POST",
      headers: { "content-type": "application/json", authorization: `Bearer ${this.token.value}` },
    });
    say(this.note, answer.ok ? "It is being written." : await answer.text());
    if (answer.ok) setTimeout(() => this.refresh(), 3000);
  }
}
