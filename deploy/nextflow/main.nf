// An experiment in shards, a task each, wherever Nextflow starts tasks; then one table of all rows.
//
//   nextflow run main.nf --experiment $PWD/lag.json --shards 8
//
// A file needs its whole path, since each task has a folder of its own. Rows do not depend on the number of shards or machines.
nextflow.enable.dsl = 2

params.experiment = 'experiments/lockstep_loss' // or a file
params.shards = 8
params.laglab = 'laglab'
params.out = '.'

process shard {
    cpus 1

    input:
    val i

    output:
    path "${i}.csv"

    script:
    """
    ${params.laglab} sweep ${params.experiment} --shard ${i}/${params.shards} --jobs ${task.cpus} --out ${i}.csv
    """
}

process merge {
    publishDir params.out, mode: 'copy'

    input:
    path shards

    output:
    path 'rows.csv'

    script:
    """
    ${params.laglab} merge ${params.experiment} ${shards} --out rows.csv
    """
}

workflow {
    shards = shard(Channel.of(1..params.shards))
    merge(shards.collect())
}
