// The address's fragment, which names the page that is shown.

export function go(hash) {
  location.hash = hash;
}
