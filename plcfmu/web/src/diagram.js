/** @param {HTMLElement} _content */
export function mount(_content) {}
