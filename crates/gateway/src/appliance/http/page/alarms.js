// The alarm list by ISA-18.2 (IEC 62682), and what people do with alarms.

import { QUANTITIES, element, millimetres, say, utc } from "./words.js";

const STATES = {
  normal: "normal",
  unacknowledged: "unacknowledged, active",
  acknowledged: "acknowledged, active",
  returned_unacknowledged: "unacknowledged, returned",
  interrupted_unacknowledged: "unacknowledged, the gateway stopped meanwhile",
  shelved: "shelved",
  suppressed: "suppressed: not judged in this state of the platform",
};
const SHELVINGS = [[60, "1 hour"], [480, "8 hours"], [1440, "1 day"], [10080, "7 days"]];

export class Alarms {
  constructor(place, spoken) {
    this.place = place;
    this.spoken = spoken;
    this.list = element("ul", { class: "incidents alarms" });
    this.note = element("p");
    this.place.replaceChildren(element("h2", {}, "Alarms"), this.note, this.list);
    this.dialog = null;
  }

  /** Reads the list again; the text is only changed where it differs. */
  async refresh() {
    const answer = await fetch("/api/alarms");
    if (!answer.ok) return say(this.note, await answer.text());
    const found = await answer.json();
    const { store, alarms } = found;
    if (!store.path) {
      say(this.note, `${store.trouble ?? "Nothing is kept (no [store] in the configuration)."} Below is what stands now; it cannot be acknowledged.`);
      return null;
    }
    say(this.note, store.trouble ? `The store is not written: ${store.trouble}`
      : alarms.length === 0 ? "No alarm is active or waits to be acknowledged." : "");
    // What changes with each cycle is changed in its place, so that a button keeps its focus.
    const key = JSON.stringify(found, (name, value) => (name === "now_m" ? undefined : value));
    if (key !== this.key && !this.dialog?.open) {
      this.key = key;
      this.now = new Map();
      this.list.replaceChildren(...alarms.map((alarm) => this.row(alarm, found.acts)));
    }
    for (const alarm of alarms) {
      const { quantity, now_m: now } = alarm;
      const place = this.now?.get(alarm.incident);
      if (place) say(place, now == null ? "" : `; ${QUANTITIES[quantity] ?? quantity} is ${millimetres(now)} now`);
    }
    return found;
  }

  /** Shows what stands, where nothing is kept. */
  fallback(rows) {
    this.list.replaceChildren(...rows);
  }

  row(alarm, acts) {
    const { state } = alarm;
    const details = [`since ${utc(alarm.begin_s)}`];
    if (alarm.end_s != null) details.push(`${alarm.ending} ${utc(alarm.end_s)}`);
    if (alarm.acknowledged_by) details.push(`acknowledged by ${alarm.acknowledged_by}${alarm.acknowledged_note ? `: ${alarm.acknowledged_note}` : ""}`);
    if (state === "shelved") details.push(`shelved until ${utc(alarm.shelved_until_s)} by ${alarm.shelved_by}: ${alarm.shelved_reason}`);
    const button = (name, kind) => {
      const node = element("button", { type: "button", "aria-label": `${name}: ${alarm.text}` }, name);
      node.addEventListener("click", () => this.ask(alarm, kind, name));
      return node;
    };
    const waits = state.includes("unacknowledged");
    const buttons = !acts ? [] : [
      waits ? button("Acknowledge", "acknowledge") : null,
      state === "shelved" ? button("Unshelve", "unshelve") : button("Shelve", "shelve"),
    ];
    const now = element("span");
    this.now.set(alarm.incident, now);
    return element("li", { class: state },
      element("span", { class: `level ${alarm.level}` }, alarm.level), " ",
      element("a", { href: `#incidents/${alarm.incident}` }, alarm.text), " ",
      element("strong", { class: "state" }, STATES[state] ?? state),
      element("p", { class: "quiet" }, details.join("; "), now),
      element("p", { class: "buttons" }, ...buttons));
  }

  /** Asks who does it and why, and does it. */
  ask(alarm, kind, name) {
    const field = (label, node) => element("label", {}, label, node);
    const who = element("input", { name: "who", required: true, maxlength: 80, autocomplete: "name", value: localStorage.getItem("who") ?? "" });
    const note = element("input", { name: "note", maxlength: 500, required: kind === "shelve" });
    const token = element("input", { name: "token", type: "password", required: true, autocomplete: "off", value: sessionStorage.getItem("token") ?? "" });
    const length = element("select", { name: "minutes" }, ...SHELVINGS.map(([minutes, text]) => element("option", { value: minutes }, text)));
    const trouble = element("p", { role: "alert", class: "trouble" });
    const close = element("button", { type: "button" }, "Cancel");
    const form = element("form", { method: "dialog" },
      element("h2", {}, name), element("p", {}, alarm.text),
      field("Your name", who), field(kind === "shelve" ? "Reason" : "Note", note),
      kind === "shelve" ? field("For", length) : null, field("Token", token), trouble,
      element("p", { class: "buttons" }, element("button", { type: "submit" }, name), close));
    this.dialog = element("dialog", { "aria-label": name }, form);
    const dialog = this.dialog;
    dialog.addEventListener("close", () => dialog.remove());
    close.addEventListener("click", () => dialog.close());
    form.addEventListener("submit", async (event) => {
      event.preventDefault();
      localStorage.setItem("who", who.value);
      sessionStorage.setItem("token", token.value);
      const answer = await fetch(`/api/alarms/${alarm.incident}/${kind}`, {
        method: "POST",
        headers: { "content-type": "application/json", authorization: `Bearer ${token.value}` },
        body: JSON.stringify({ who: who.value, note: note.value, minutes: Number(length.value) }),
      }).catch((error) => ({ ok: false, text: async () => error.message }));
      if (!answer.ok) return say(trouble, await answer.text());
      dialog.close();
      say(this.spoken, `${name}: done.`);
      await this.refresh();
    });
    this.place.append(dialog);
    dialog.showModal();
  }
}
