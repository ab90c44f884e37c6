// SPDX-License-Identifier: Apache-2.0

// Asks one question at a time and always the newest: what comes while one is being answered waits, and replaces what waited.
// Answers to questions that were withdrawn are not told.
export class Latest<Question, Answer> {
  private waiting: { question: Question } | undefined;
  private busy = false;
  private round = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;

  // `gapMs`: between an answer and the next question.
  constructor(
    private readonly ask: (question: Question) => Promise<Answer>,
    private readonly tell: (question: Question, answer: Answer | undefined, error: unknown) => void,
    private readonly gapMs = 100,
  ) {}

  want(question: Question) {
    this.waiting = { question };
    if (!this.busy) void this.next();
  }

  withdraw() {
    this.waiting = undefined;
    ++this.round;
  }

  private async next() {
    const { waiting, round } = this;
    if (!waiting) return;
    this.waiting = undefined;
    this.busy = true;
    let answer: Answer | undefined;
    let error: unknown;
    try {
      answer = await this.ask(waiting.question);
    } catch (failure) {
      error = failure;
    }
    if (round === this.round) this.tell(waiting.question, answer, error);
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      this.busy = false;
      void this.next();
    }, this.gapMs);
  }
}
