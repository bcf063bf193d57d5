export class Moving { constructor() { throw new Error("not built yet"); } }
