/** The command with what is set aside before its last words, `-o NEW`; names as a shell takes them. */
export function decided(words, aside) {
  const options = aside.map(
    (name) => ` --set-aside ${/^[\w.-]+$/.test(name) ? name : `'${name.replaceAll("'", "'\\''")}'`}`,
  );
  return words.replace(/ -o NEW$/, () => `${options.join("")} -o NEW`);
}
