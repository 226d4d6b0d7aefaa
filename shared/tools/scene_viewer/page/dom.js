// What every part of the page does with its elements.

export const byId = (id) => document.getElementById(id);

/// Says something that is over: under the picture for some seconds, and to whoever listens.
let said = 0;
export function say(text) {
  byId('said').textContent = text;
  byId('said').hidden = false;
  clearTimeout(said);
  said = setTimeout(() => { byId('said').hidden = true; }, 4000);
}

/// Puts text where the user can paste it; false where the browser gives no clipboard.
export async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    return false;
  }
}
